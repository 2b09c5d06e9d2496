//! Robots from URDF descriptions.

use super::chain::{Joint, JointKind, Robot};
use super::urdf_document::{DescribedJoint, Description, JointType};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use std::collections::HashMap;

/// Why a description gives no serial robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UrdfError {
    /// No URDF.
    #[error("not a URDF file: {message}; xacro files must be expanded first (xacro robot.xacro > robot.urdf)")]
    Syntax {
        /// What the parser says.
        message: String,
    },
    /// A link that is not there.
    #[error("no link `{link}`; there are: {known}")]
    NoLink {
        /// Its name.
        link: String,
        /// Links of the description.
        known: String,
    },
    /// Several ends to choose from.
    #[error("the {what} is ambiguous; choose one of: {choices}")]
    Choose {
        /// Base or tip.
        what: &'static str,
        /// Links that it may be.
        choices: String,
    },
    /// Base and tip are not connected.
    #[error("link `{tip}` is not connected to link `{base}`: the chain from it ends at `{end}`")]
    NoChain {
        /// Base link.
        base: String,
        /// Tip link.
        tip: String,
        /// Where the chain ends.
        end: String,
    },
    /// A joint that a serial robot cannot have.
    #[error("joint `{joint}`: {reason}")]
    Joint {
        /// Its name.
        joint: String,
        /// What is wrong, with the remedy.
        reason: &'static str,
    },
}

impl Robot {
    /// A robot from the text of a URDF description: the joints between the links `base` and `tip`, fixed ones merged. Without a
    /// name the base is the link that hangs on none, the tip the only one on which none hangs. The tool point is the tip's frame.
    ///
    /// # Errors
    /// [`UrdfError`] for a text that is no URDF, links that are not there, and joints that are neither fixed, revolute
    /// nor prismatic.
    pub fn from_urdf(text: &str, base: Option<&str>, tip: Option<&str>) -> Result<Self, UrdfError> {
        let description = Description::read(text).map_err(|message| UrdfError::Syntax { message })?;
        let parents: HashMap<&str, &DescribedJoint> =
            description.joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
        let links: Vec<&str> = description.links.iter().map(String::as_str).collect();
        let base = named(&links, base, "base link", |link| !parents.contains_key(link))?;
        let hangs = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
        let tip = named(&links, tip, "tip link", |link| !hangs(link))?;

        let mut chain = Vec::new();
        let mut link = tip;
        while link != base {
            // A chain longer than all joints goes round in a circle.
            match parents.get(link) {
                Some(joint) if chain.len() < description.joints.len() => {
                    chain.push(*joint);
                    link = &joint.parent;
                }
                _ => return Err(UrdfError::NoChain { base: base.into(), tip: tip.into(), end: link.into() }),
            }
        }
        chain.reverse();

        let mut robot = Self { name: description.name.clone(), joints: Vec::new(), tool: Isometry3::identity() };
        for joint in chain {
            robot.tool *= pose(joint)?;
            if let Some(kind) = kind(joint)? {
                let axis = Unit::try_new(Vector3::from(joint.axis), 1e-9);
                let axis = axis.filter(|axis| axis.iter().all(|v| v.is_finite()));
                let axis = axis.ok_or_else(|| refused(joint, "its axis has no direction; correct <axis xyz>"))?;
                let placement = std::mem::replace(&mut robot.tool, Isometry3::identity());
                robot.joints.push(Joint { name: joint.name.clone(), kind, placement, axis, offset: 0.0 });
            }
        }
        if robot.joints.is_empty() {
            return Err(UrdfError::Choose { what: "chain without a movable joint", choices: links.join(", ") });
        }
        Ok(robot)
    }
}

/// The link of a name, or the only one that fits.
fn named<'a>(
    links: &[&'a str],
    name: Option<&str>,
    what: &'static str,
    fits: impl Fn(&str) -> bool,
) -> Result<&'a str, UrdfError> {
    if let Some(name) = name {
        return links
            .iter()
            .find(|link| **link == name)
            .copied()
            .ok_or_else(|| UrdfError::NoLink { link: name.to_owned(), known: links.join(", ") });
    }
    let fitting: Vec<&str> = links.iter().copied().filter(|link| fits(link)).collect();
    match fitting[..] {
        [only] => Ok(only),
        _ => Err(UrdfError::Choose { what, choices: fitting.join(", ") }),
    }
}

fn pose(joint: &DescribedJoint) -> Result<Isometry3<f64>, UrdfError> {
    let ([x, y, z], [roll, pitch, yaw]) = (joint.xyz, joint.rpy);
    if [x, y, z, roll, pitch, yaw].iter().any(|v| !v.is_finite()) {
        return Err(refused(joint, "its origin has a number that is not finite; correct <origin>"));
    }
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

fn refused(joint: &DescribedJoint, reason: &'static str) -> UrdfError {
    UrdfError::Joint { joint: joint.name.clone(), reason }
}

/// What a joint does; none where it is fixed.
fn kind(joint: &DescribedJoint) -> Result<Option<JointKind>, UrdfError> {
    if joint.mimics {
        let reason = "it mimics another one, which a serial robot does not; choose base and tip to leave it out";
        return Err(refused(joint, reason));
    }
    match joint.kind {
        JointType::Fixed => Ok(None),
        JointType::Revolute | JointType::Continuous => Ok(Some(JointKind::Revolute)),
        JointType::Prismatic => Ok(Some(JointKind::Prismatic)),
        JointType::SeveralDegrees => {
            Err(refused(joint, "it has several degrees of freedom; choose base and tip to leave it out"))
        }
    }
}
