//! Robot files: kinematics, springs, sensor, payload and compensation in TOML.

use super::joints::{DEGREES, LENGTH, URDF_KEYS, dh_row, joint_tables, only_keys, springs};
use crate::compensate::{CompensationSettings, FilterOrder};
use crate::compliance::Springs;
use crate::robot::{DhParameters, Robot, Wrench};
use crate::sensor::{ForceSensor, Payload};
use bracketry_files::{Document, FileError, Plausible, Table};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::path::Path;

const DEVIATION_LENGTH: Plausible = Plausible::new(1e-9, 0.01, "m", "give a standard deviation in m: 20 µm is 20e-6");
const DEVIATION_ANGLE: Plausible =
    Plausible::new(1e-9, 0.1, "rad", "give a standard deviation in rad: 50 µrad is 50e-6");
const DEVIATION_LOAD: Plausible = Plausible::new(1e-6, 1e4, "N or N·m", "give a standard deviation in N or N·m");
const MASS: Plausible = Plausible::new(0.0, 5000.0, "kg", "give the mass in kg");
const LOAD: Plausible = Plausible::new(-1e6, 1e6, "N or N·m", "give forces in N, moments in N·m");
const RANGE: Plausible = Plausible::new(1e-3, 1e7, "N or N·m", "give the sensor's range in N or N·m");
const PERIOD: Plausible = Plausible::new(1e-6, 1.0, "s", "give the period in s: 4 ms is 0.004");
const CUTOFF: Plausible = Plausible::new(1e-3, 1e5, "Hz", "give the cutoff in Hz");
const LIMIT: Plausible = Plausible::new(1e-9, 0.2, "rad", "give the limit in rad: 10 mrad is 0.01");
const RATE: Plausible = Plausible::new(1e-9, 100.0, "rad/s", "give the limit in rad/s");
const LAG: Plausible = Plausible::new(0.0, 1.0, "s", "give the lag of the servo in s: 12 ms is 0.012");
const SHARE: Plausible = Plausible::new(0.0, 0.9, "(a share)", "give the assumed error as a fraction: 10 % is 0.1");
const GRAVITY: Plausible = Plausible::new(-20.0, 20.0, "m/s²", "give gravity in base axes in m/s², as [0, 0, -9.81]");
const STEPS: Plausible = Plausible::new(0.0, 10.0, "steps", "two are enough");
const ORDER: Plausible = Plausible::new(1.0, 2.0, "poles", "write order = 1 or order = 2");

/// Descriptions larger than this are refused.
const MAX_BYTES: u64 = 16 << 20;

const TOP_KEYS: [&str; 11] =
    ["name", "convention", "urdf", "base", "tip", "joint", "tool", "sensor", "payload", "noise", "compensation"];
const COMPENSATION_KEYS: [&str; 9] = [
    "period",
    "cutoff",
    "order",
    "lag",
    "stiffness_error",
    "newton_steps",
    "correction_limit",
    "rate_limit",
    "gravity",
];
/// Standard deviations of what is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLevels {
    /// Of a translation (m).
    pub translation: f64,
    /// Of a rotation (rad).
    pub rotation: f64,
    /// Of a force (N).
    pub force: f64,
    /// Of a moment (N·m).
    pub moment: f64,
}

impl Default for NoiseLevels {
    /// 20 µm, 50 µrad, 2 N, 0.5 N·m.
    fn default() -> Self {
        Self { translation: 20e-6, rotation: 50e-6, force: 2.0, moment: 0.5 }
    }
}

/// What a robot file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFile {
    /// The robot with its tool.
    pub robot: Robot,
    /// Springs of its joints and links, where the file gives them.
    pub springs: Option<Springs>,
    /// The force sensor, where it has one.
    pub sensor: Option<ForceSensor>,
    /// What the sensor carries.
    pub payload: Payload,
    /// Noise of measurement.
    pub noise: NoiseLevels,
    /// Settings of the compensation.
    pub compensation: CompensationSettings,
}

impl RobotFile {
    /// Reads a robot file; a URDF description that it names is looked for beside it.
    ///
    /// # Errors
    /// [`FileError`] with file, line and remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        Self::from_document(&read(path)?, path.parent().unwrap_or(Path::new("")))
    }

    /// A robot from the text of a file of that name; `folder` is where URDF descriptions are looked for.
    ///
    /// # Errors
    /// As [`RobotFile::read`].
    pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Self, FileError> {
        Self::from_document(&Document::new(file, text), folder)
    }

    fn from_document(document: &Document, folder: &Path) -> Result<Self, FileError> {
        let table = document.table()?;
        only_keys(document, &table, &TOP_KEYS, "a robot file")?;
        let joints = joint_tables(document, &table)?;
        let mut robot = if table.contains_key("urdf") {
            from_urdf(document, &table, &joints, folder)?
        } else {
            from_dh(document, &table, &joints)?
        };
        if let Some(name) = document.string(&table, "name")? {
            robot.name = name;
        }
        for (joint, given) in robot.joints.iter_mut().zip(&joints) {
            if let Some(name) = document.string(given, "name")? {
                joint.name = name;
            }
        }
        let springs = springs(document, &robot, &joints)?;
        let tool = match document.sub_table(&table, "tool")? {
            None => Isometry3::identity(),
            Some(tool) => {
                only_keys(document, tool, &["position", "rpy_deg"], "[tool]")?;
                pose(document, tool)?
            }
        };
        Ok(Self {
            robot: robot.with_tool(tool),
            springs,
            sensor: sensor(document, &table, &tool)?,
            payload: payload(document, &table)?,
            noise: noise(document, &table)?,
            compensation: compensation(document, &table)?,
        })
    }
}

/// Reads a description of a robot.
fn read(path: &Path) -> Result<Document, FileError> {
    Document::read_up_to(path, MAX_BYTES, "name a file", "is this really the description of a robot?")
}

fn from_dh(document: &Document, table: &Table<'_>, joints: &[&Table<'_>]) -> Result<Robot, FileError> {
    let Some(convention) = document.string(table, "convention")? else {
        let remedy = "write convention = \"modified\" or \"standard\" for Denavit–Hartenberg parameters, or urdf = \"robot.urdf\"";
        return Err(document.missing("does not define the kinematics", remedy));
    };
    for key in ["base", "tip"] {
        if let Some((key, _)) = table.get_key_value(key) {
            return Err(document.error(key.span(), "base and tip belong to a URDF description", "remove it"));
        }
    }
    if joints.is_empty() {
        return Err(document.missing("has no joints", "write one [[joint]] for each joint, from the base on"));
    }
    let rows: Vec<DhParameters> = joints.iter().map(|joint| dh_row(document, joint)).collect::<Result<_, _>>()?;
    match convention.as_str() {
        "modified" => Ok(Robot::from_modified_dh("robot", &rows)),
        "standard" => Ok(Robot::from_standard_dh("robot", &rows)),
        _ => {
            let span = table.get("convention").map_or(0..0, toml::Spanned::span);
            Err(document.error(
                span,
                format!("`{convention}` is not a convention"),
                "write \"modified\" (Craig) or \"standard\"",
            ))
        }
    }
}

fn from_urdf(document: &Document, table: &Table<'_>, joints: &[&Table<'_>], folder: &Path) -> Result<Robot, FileError> {
    if let Some((key, _)) = table.get_key_value("convention") {
        return Err(document.error(
            key.span(),
            "both `urdf` and `convention`",
            "keep the one that describes the robot",
        ));
    }
    for joint in joints {
        only_keys(document, joint, &URDF_KEYS, "[[joint]] with a URDF description")?;
    }
    let name = document.string(table, "urdf")?.unwrap_or_default();
    let described = read(&folder.join(&name))?;
    let (base, tip) = (document.string(table, "base")?, document.string(table, "tip")?);
    let robot = Robot::from_urdf(described.text(), base.as_deref(), tip.as_deref()).map_err(|e| {
        let span = table.get("urdf").map_or(0..0, toml::Spanned::span);
        document.error(span, format!("{name}: {e}"), "write base = \"…\" and tip = \"…\" with the links of the chain")
    })?;
    if !joints.is_empty() && joints.len() != robot.joints.len() {
        let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
        let message = format!("{} [[joint]] entries for {} joints", joints.len(), names.len());
        return Err(document.missing(message, format!("write one for each, in this order: {}", names.join(", "))));
    }
    Ok(robot)
}

fn pose(document: &Document, table: &Table<'_>) -> Result<Isometry3<f64>, FileError> {
    let [x, y, z] = document.plausible_numbers(table, "position", &LENGTH)?.unwrap_or_default();
    let [roll, pitch, yaw] =
        document.plausible_numbers::<3>(table, "rpy_deg", &DEGREES)?.unwrap_or_default().map(f64::to_radians);
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

fn sensor(document: &Document, table: &Table<'_>, tool: &Isometry3<f64>) -> Result<Option<ForceSensor>, FileError> {
    let Some(sensor) = document.sub_table(table, "sensor")? else { return Ok(None) };
    only_keys(document, sensor, &["position", "rpy_deg", "force_range", "moment_range"], "[sensor]")?;
    let range = |key: &str| {
        document.plausible_number(sensor, key, &RANGE)?.ok_or_else(|| {
            document.missing(format!("[sensor] has no `{key}`"), "give the largest valid reading, in N or N·m")
        })
    };
    // In the file both poses are in the frame that ends the robot.
    let pose = tool.inverse() * pose(document, sensor)?;
    Ok(Some(ForceSensor { pose, force_range: range("force_range")?, moment_range: range("moment_range")? }))
}

fn payload(document: &Document, table: &Table<'_>) -> Result<Payload, FileError> {
    let Some(payload) = document.sub_table(table, "payload")? else { return Ok(Payload::none()) };
    only_keys(document, payload, &["mass", "centre", "bias"], "[payload]")?;
    Ok(Payload {
        mass: document.plausible_number(payload, "mass", &MASS)?.unwrap_or(0.0),
        center: Vector3::from(document.plausible_numbers(payload, "centre", &LENGTH)?.unwrap_or_default()),
        bias: Wrench::from(document.plausible_numbers(payload, "bias", &LOAD)?.unwrap_or_default()),
    })
}

fn noise(document: &Document, table: &Table<'_>) -> Result<NoiseLevels, FileError> {
    let mut levels = NoiseLevels::default();
    let Some(noise) = document.sub_table(table, "noise")? else { return Ok(levels) };
    only_keys(document, noise, &["translation", "rotation", "force", "moment"], "[noise]")?;
    for (key, level, range) in [
        ("translation", &mut levels.translation, &DEVIATION_LENGTH),
        ("rotation", &mut levels.rotation, &DEVIATION_ANGLE),
        ("force", &mut levels.force, &DEVIATION_LOAD),
        ("moment", &mut levels.moment, &DEVIATION_LOAD),
    ] {
        *level = document.plausible_number(noise, key, range)?.unwrap_or(*level);
    }
    Ok(levels)
}

fn compensation(document: &Document, table: &Table<'_>) -> Result<CompensationSettings, FileError> {
    let mut settings = CompensationSettings::default();
    let Some(given) = document.sub_table(table, "compensation")? else { return Ok(settings) };
    only_keys(document, given, &COMPENSATION_KEYS, "[compensation]")?;
    for (key, setting, range) in [
        ("period", &mut settings.period, &PERIOD),
        ("cutoff", &mut settings.cutoff, &CUTOFF),
        ("stiffness_error", &mut settings.stiffness_error, &SHARE),
        ("correction_limit", &mut settings.correction_limit, &LIMIT),
        ("rate_limit", &mut settings.rate_limit, &RATE),
    ] {
        *setting = document.plausible_number(given, key, range)?.unwrap_or(*setting);
    }
    settings.lag = document.plausible_number(given, "lag", &LAG)?;
    if let Some(steps) = whole(document, given, "newton_steps", &STEPS)? {
        settings.newton_steps = steps;
    }
    if let Some(order) = whole(document, given, "order", &ORDER)? {
        settings.order = if order == 1 { FilterOrder::First } else { FilterOrder::Second };
    }
    if let Some(gravity) = document.plausible_numbers(given, "gravity", &GRAVITY)? {
        settings.gravity = Vector3::from(gravity);
    }
    if settings.cutoff * settings.period >= 0.5 {
        let span = given.get("cutoff").or(given.get("period")).map_or(0..0, toml::Spanned::span);
        let message = format!("a cutoff of {} Hz at a period of {} s", settings.cutoff, settings.period);
        return Err(document.error(span, message, "the cutoff must lie below half the sampling rate"));
    }
    Ok(settings)
}

/// A whole number.
fn whole(document: &Document, table: &Table<'_>, key: &str, range: &Plausible) -> Result<Option<usize>, FileError> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let number = document.plausible(value, key, range)?;
    if number.fract() != 0.0 {
        return Err(document.error(value.span(), format!("`{key}` is not a whole number"), range.remedy()));
    }
    Ok(Some(number as usize))
}
