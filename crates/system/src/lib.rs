//! Control systems: model files, parameters, switching modes, affine forms, compiled right-hand sides.
