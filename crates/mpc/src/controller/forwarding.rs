//! Methods of a controller that stands in front of another one.

/// Implements the named methods of [`Controller`](super::Controller) by those of the controller inside:
/// `forward_to!(self => self.controller; prepare, plan)`.
macro_rules! forward_to {
    ($this:ident => $inner:expr; $($method:ident),+ $(,)?) => {
        $( forward_to!(@ $method, $this, $inner); )+
    };
    (@ prepare, $this:ident, $inner:expr) => {
        fn prepare(&mut $this) -> Result<(), $crate::MpcError> {
            $inner.prepare()
        }
    };
    (@ feedback, $this:ident, $inner:expr) => {
        fn feedback(&mut $this, x: &[f64]) -> Result<&$crate::Step, $crate::MpcError> {
            $inner.feedback(x)
        }
    };
    (@ shift, $this:ident, $inner:expr) => {
        fn shift(&mut $this) {
            $inner.shift();
        }
    };
    (@ skip, $this:ident, $inner:expr) => {
        fn skip(&mut $this) -> Result<(), $crate::MpcError> {
            $inner.skip()
        }
    };
    (@ estimate, $this:ident, $inner:expr) => {
        fn estimate(&$this) -> Option<&$crate::Estimate> {
            $inner.estimate()
        }
    };
    (@ plan, $this:ident, $inner:expr) => {
        fn plan(&$this) -> &$crate::Trajectory {
            $inner.plan()
        }
    };
    (@ ocp, $this:ident, $inner:expr) => {
        fn ocp(&$this) -> &$crate::Ocp {
            $inner.ocp()
        }
    };
    (@ change, $this:ident, $inner:expr) => {
        fn change(&mut $this, change: &mut dyn FnMut(&mut $crate::Ocp)) -> Result<(), $crate::MpcError> {
            $inner.change(change)
        }
    };
    (@ set_start, $this:ident, $inner:expr) => {
        fn set_start(&mut $this, k0: usize) {
            $inner.set_start(k0);
        }
    };
    (@ limit_next_step, $this:ident, $inner:expr) => {
        fn limit_next_step(&mut $this, limits: $crate::StepLimits) {
            $inner.limit_next_step(limits);
        }
    };
    (@ relaxed_plan, $this:ident, $inner:expr) => {
        fn relaxed_plan(&$this) -> Option<&$crate::Trajectory> {
            $inner.relaxed_plan()
        }
    };
    (@ figures, $this:ident, $inner:expr) => {
        fn figures(&$this) -> $crate::Figures {
            $inner.figures()
        }
    };
    (@ set_parameters, $this:ident, $inner:expr) => {
        fn set_parameters(&mut $this, parameters: &[f64]) -> Result<(), $crate::MpcError> {
            $inner.set_parameters(parameters)
        }
    };
}

pub(crate) use forward_to;
