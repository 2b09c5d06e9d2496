//! What a URDF description says of links and joints. Masses, shapes, and whatever else it holds are passed over.

use roxmltree::{Document, Node};

/// A description.
pub(super) struct Description {
    pub(super) name: String,
    /// Names of the links.
    pub(super) links: Vec<String>,
    pub(super) joints: Vec<DescribedJoint>,
}

/// A joint between two links, as described.
pub(super) struct DescribedJoint {
    pub(super) name: String,
    pub(super) kind: JointType,
    pub(super) parent: String,
    pub(super) child: String,
    /// Where the joint is in the frame of the parent: translation, m; roll, pitch, yaw, rad. Zero where it is not given.
    pub(super) xyz: [f64; 3],
    pub(super) rpy: [f64; 3],
    /// Axis in the frame of the joint; along x where it is not given.
    pub(super) axis: [f64; 3],
    /// Whether it follows another joint.
    pub(super) mimics: bool,
}

/// Types of joints, as far as they differ here.
#[derive(Clone, Copy)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    SeveralDegrees,
}

impl Description {
    /// Reads the text of a description.
    ///
    /// # Errors
    /// What is wrong, with line and column.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let document = Document::parse(text).map_err(|e| e.to_string())?;
        let robot = document.root_element();
        if !robot.has_tag_name("robot") {
            return Err(at(robot, &format!("<{}> where <robot> is expected", robot.tag_name().name())));
        }
        let of = |tag: &'static str| robot.children().filter(move |n| n.has_tag_name(tag));
        Ok(Self {
            name: attribute(robot, "name")?,
            links: of("link").map(|link| attribute(link, "name")).collect::<Result<_, _>>()?,
            joints: of("joint").map(DescribedJoint::read).collect::<Result<_, _>>()?,
        })
    }
}

impl DescribedJoint {
    fn read(joint: Node<'_, '_>) -> Result<Self, String> {
        let child = |tag: &str| joint.children().find(|n| n.has_tag_name(tag));
        let link = |tag: &str| {
            let node = child(tag).ok_or_else(|| at(joint, &format!("<joint> without <{tag}>")))?;
            attribute(node, "link")
        };
        let vector = |tag: &str, name: &str, absent: [f64; 3]| {
            let node = child(tag).filter(|n| n.has_attribute(name));
            node.map_or(Ok(absent), |n| numbers(n, name))
        };
        let kind = match attribute(joint, "type")?.as_str() {
            "fixed" => JointType::Fixed,
            "revolute" => JointType::Revolute,
            "continuous" => JointType::Continuous,
            "prismatic" => JointType::Prismatic,
            "floating" | "planar" | "spherical" => JointType::SeveralDegrees,
            other => return Err(at(joint, &format!("`{other}` is not a joint type"))),
        };
        Ok(Self {
            name: attribute(joint, "name")?,
            kind,
            parent: link("parent")?,
            child: link("child")?,
            xyz: vector("origin", "xyz", [0.0; 3])?,
            rpy: vector("origin", "rpy", [0.0; 3])?,
            axis: vector("axis", "xyz", [1.0, 0.0, 0.0])?,
            mimics: child("mimic").is_some(),
        })
    }
}

fn attribute(node: Node<'_, '_>, name: &str) -> Result<String, String> {
    let missing = || at(node, &format!("<{}> without `{name}`", node.tag_name().name()));
    node.attribute(name).map(str::to_owned).ok_or_else(missing)
}

fn numbers(node: Node<'_, '_>, name: &str) -> Result<[f64; 3], String> {
    let text = node.attribute(name).unwrap_or_default();
    let values: Vec<f64> = text.split_whitespace().map_while(|number| number.parse().ok()).collect();
    let complete = text.split_whitespace().count() == 3;
    let three = complete.then(|| <[f64; 3]>::try_from(values).ok()).flatten();
    three.ok_or_else(|| at(node, &format!("`{name}` of <{}> is not three numbers", node.tag_name().name())))
}

/// A message with the place of a node.
fn at(node: Node<'_, '_>, message: &str) -> String {
    format!("{message}, at {}", node.document().text_pos_at(node.range().start))
}
