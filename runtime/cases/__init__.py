"""Cases: model, scene, values and settings of a run as data in a YAML or JSON file."""
