//! Optimal control on Clarabel: multiple shooting, SQP, real-time iteration.
