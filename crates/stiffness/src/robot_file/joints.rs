//! `[[joint]]`: its place in the chain and its spring.

use crate::compliance::{JointSpring, Springs};
use crate::robot::{DhParameters, Robot};
use bracketry_files::{Document, FileError, Plausible, Table, Value};
use nalgebra::{Matrix6, Vector6};

pub(super) const LENGTH: Plausible = Plausible::new(-20.0, 20.0, "m", "give lengths in m, not mm");
pub(super) const DEGREES: Plausible = Plausible::new(-360.0, 360.0, "degrees", "give the angle in degrees");
const STIFFNESS: Plausible =
    Plausible::new(1.0, 1e11, "N·m/rad", "give the stiffness in N·m/rad (N/m for a prismatic joint)");
const CUBIC: Plausible = Plausible::new(0.0, 1e20, "N·m/rad³", "leave it out for a linear spring");
const GAP: Plausible =
    Plausible::new(0.0, 0.05, "rad", "give the lost motion from flank to flank in rad: 1' is 2.9e-4");
const TORQUE: Plausible = Plausible::new(1e-6, 1e6, "N·m", "give the torque at which the flanks engage in N·m");
const LINK: Plausible = Plausible::new(
    0.0,
    1e-3,
    "m/N, rad/(N·m)",
    "give compliances, three of translation in m/N and three of rotation in rad/(N·m): 1/k of a stiffness k, 0 where rigid",
);
const DH_KEYS: [&str; 10] =
    ["name", "alpha_deg", "a", "d", "offset_deg", "stiffness", "cubic", "gap", "engaged", "link_compliance"];
pub(super) const URDF_KEYS: [&str; 6] = ["name", "stiffness", "cubic", "gap", "engaged", "link_compliance"];

/// Refuses keys that are not in `known`, which are few enough to be listed.
pub(super) fn only_keys(document: &Document, table: &Table<'_>, known: &[&str], what: &str) -> Result<(), FileError> {
    let unknown = table.keys().find(|key| !known.contains(&key.get_ref().as_ref()));
    unknown.map_or(Ok(()), |key| {
        let message = format!("unknown key `{}` in {what}", key.get_ref());
        Err(document.error(key.span(), message, format!("{what} accepts: {}", known.join(", "))))
    })
}

/// The entries of `[[joint]]`.
pub(super) fn joint_tables<'t, 'i>(document: &Document, table: &'t Table<'i>) -> Result<Vec<&'t Table<'i>>, FileError> {
    let remedy = "write one [[joint]] for each joint, from the base on";
    let Some(value) = table.get("joint") else { return Ok(Vec::new()) };
    let wrong = |span| document.error(span, "`joint` must be a list of tables", remedy);
    let Value::Array(entries) = value.get_ref() else { return Err(wrong(value.span())) };
    entries
        .iter()
        .map(|entry| match entry.get_ref() {
            Value::Table(t) => Ok(t),
            _ => Err(wrong(entry.span())),
        })
        .collect()
}

pub(super) fn dh_row(document: &Document, joint: &Table<'_>) -> Result<DhParameters, FileError> {
    only_keys(document, joint, &DH_KEYS, "[[joint]]")?;
    let length = |key| Ok(document.plausible_number(joint, key, &LENGTH)?.unwrap_or(0.0));
    let angle = |key: &str| {
        let Some(value) = joint.get(key) else { return Ok(0.0) };
        let degrees = document.plausible(value, key, &DEGREES)?;
        // A quarter or half turn to the digits that people write is no angle in degrees.
        for (radians, instead) in [(std::f64::consts::FRAC_PI_2, 90), (std::f64::consts::PI, 180)] {
            if (degrees.abs() - radians).abs() < 1e-3 {
                let sign = if degrees < 0.0 { "-" } else { "" };
                let remedy = format!("this key is in degrees: write {key} = {sign}{instead}");
                return Err(document.error(
                    value.span(),
                    format!("`{key}` is {degrees}, which looks like radians"),
                    remedy,
                ));
            }
        }
        Ok(degrees.to_radians())
    };
    Ok(DhParameters { alpha: angle("alpha_deg")?, a: length("a")?, d: length("d")?, offset: angle("offset_deg")? })
}

/// The springs, given for all joints or for none.
pub(super) fn springs(document: &Document, robot: &Robot, joints: &[&Table<'_>]) -> Result<Option<Springs>, FileError> {
    let mut springs = Vec::with_capacity(joints.len());
    for joint in joints {
        if let Some(spring) = spring(document, joint)? {
            springs.push(spring);
        }
    }
    if springs.is_empty() {
        return Ok(None);
    }
    if springs.len() != robot.joints.len() {
        let missing = joints.iter().position(|joint| !joint.contains_key("stiffness")).unwrap_or(0);
        let message = format!("joint {} ({}) has no stiffness", missing + 1, robot.joints[missing].name);
        return Err(document.missing(message, "give `stiffness` for every joint or for none"));
    }
    Ok(Some(Springs::of_joints(springs).with_links(links(document, joints)?)))
}

/// Compliances of the links behind the joints, along and about the axes of each joint's frame; none where no joint has them.
fn links(document: &Document, joints: &[&Table<'_>]) -> Result<Vec<Matrix6<f64>>, FileError> {
    let given: Vec<Option<[f64; 6]>> = joints
        .iter()
        .map(|joint| document.plausible_numbers(joint, "link_compliance", &LINK))
        .collect::<Result<_, _>>()?;
    if given.iter().all(Option::is_none) {
        return Ok(Vec::new());
    }
    Ok(given.into_iter().map(|link| Matrix6::from_diagonal(&Vector6::from(link.unwrap_or_default()))).collect())
}

pub(super) fn spring(document: &Document, joint: &Table<'_>) -> Result<Option<JointSpring>, FileError> {
    let Some(stiffness) = document.plausible_number(joint, "stiffness", &STIFFNESS)? else {
        return match ["cubic", "gap", "engaged", "link_compliance"].iter().find_map(|key| joint.get_key_value(*key)) {
            None => Ok(None),
            Some((key, _)) => {
                Err(document.error(key.span(), format!("`{}` without `stiffness`", key.get_ref()), "give both"))
            }
        };
    };
    let cubic = document.plausible_number(joint, "cubic", &CUBIC)?;
    let gap = document.plausible_number(joint, "gap", &GAP)?;
    let engaged = document.plausible_number(joint, "engaged", &TORQUE)?;
    let place = |key: &str| joint.get_key_value(key).map_or(0..0, |(key, _)| key.span());
    match (cubic, gap, engaged) {
        (None, None, None) => Ok(Some(JointSpring::linear(stiffness))),
        (Some(cubic), None, None) => Ok(Some(JointSpring::Stiffening { stiffness, cubic })),
        (None, Some(gap), Some(engaged)) => Ok(Some(JointSpring::Backlash { stiffness, gap, engaged })),
        (Some(_), ..) => Err(document.error(
            place("cubic"),
            "a spring with `cubic` and lost motion",
            "keep `cubic`, or `gap` with `engaged`",
        )),
        (None, Some(_), None) => Err(document.error(
            place("gap"),
            "`gap` without `engaged`",
            "give the torque (N·m) at which the flanks are engaged",
        )),
        (None, None, Some(_)) => {
            Err(document.error(place("engaged"), "`engaged` without `gap`", "give the lost motion `gap` in rad"))
        }
    }
}
