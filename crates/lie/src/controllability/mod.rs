//! What the inputs reach: generically, at a point, by switching.

pub(crate) mod accessibility;
pub(crate) mod brockett;
pub(crate) mod canceling;
pub(crate) mod impulses;
pub(crate) mod input_set;
pub(crate) mod input_values;
pub(crate) mod involutive;
pub(crate) mod linearization;
pub(crate) mod local;
pub(crate) mod local_degree;
pub(crate) mod monotone;
pub(crate) mod necessary;
pub(crate) mod one_sided;
pub(crate) mod point;
pub(crate) mod sign;
pub(crate) mod stlc;
pub(crate) mod sussmann;
pub(crate) mod switched;
pub(crate) mod unbounded;
pub(crate) mod uncontrollable;
