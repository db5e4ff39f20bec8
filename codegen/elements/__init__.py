"""The library of joints, drivers and forces, one file each."""
