"""The kernels of a scene, each lowered from its equations to one program."""
