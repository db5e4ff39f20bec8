"""What a modeller writes: models, bodies, joints, drivers, effects, scenes."""
