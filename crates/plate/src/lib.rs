//! The vibrating hyper-plate: published model, experiments, objects and scenarios.
