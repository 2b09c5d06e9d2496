//! What is known of the parameters of springs.

use std::fmt;

/// What the data say about a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Identified {
    /// A number.
    Yes {
        /// Its value.
        value: f64,
        /// Lower end of its 95 % interval.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Nothing useful.
    No {
        /// Standard deviation of its logarithm; infinite where it does not show at all.
        log_std: f64,
        /// Why.
        why: Unidentified,
    },
}

/// Why the data say nothing useful about a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unidentified {
    /// The loads deflect the joint by less than the noise in these poses.
    NotDeflected,
    /// The parameter changes these displacements by less than the noise.
    NoEffect,
    /// Poses and loads do not tell it from others: joint from 1 and name, the most alike first.
    Confounded(Vec<(usize, &'static str)>),
}

impl fmt::Display for Unidentified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotDeflected => f.write_str("these loads move the joint by less than the noise in these poses"),
            Self::NoEffect => {
                f.write_str("it changes these displacements by less than the noise; start elsewhere or leave it out")
            }
            Self::Confounded(others) => {
                let named: Vec<String> =
                    others.iter().map(|(joint, name)| format!("the {name} of joint {joint}")).collect();
                write!(f, "these poses and loads do not separate it from {}", named.join(" and "))
            }
        }
    }
}

impl Identified {
    /// Why the data do not tell the parameter, with the standard deviation of its logarithm; none where they do.
    pub fn why(&self) -> Option<String> {
        match self {
            Self::Yes { .. } => None,
            Self::No { log_std, why } => {
                Some(format!("{why} (standard deviation of the logarithm of the parameter: {log_std:.1})"))
            }
        }
    }
}

/// A parameter of a joint's spring.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringParameter {
    /// Joint, from 1.
    pub joint: usize,
    /// `stiffness`, `cubic`, `gap` or `engaged`.
    pub name: &'static str,
    /// What is known of it, in the units of [`crate::JointSpring`].
    pub identified: Identified,
}

impl fmt::Display for SpringParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "joint {}, {}: ", self.joint, self.name)?;
        match &self.identified {
            Identified::Yes { value, low, high } => write!(f, "{value:.4e} (95 %: {low:.4e} … {high:.4e})"),
            no @ Identified::No { .. } => write!(f, "{}", no.why().unwrap_or_default()),
        }
    }
}
