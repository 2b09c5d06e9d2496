//! Robot files: what they mean, and what is said about those that mean nothing.
#![allow(clippy::format_push_string)]

use crate::common::{STIFFNESS, kr125, milling::KR125, rng};
use bracketry_stiffness::{
    Deformation, DhParameters, FilterOrder, ForceSensor, JointKind, JointSpring, Robot, RobotFile, Springs,
    with_springs,
};
use nalgebra::{Isometry3, Matrix6, Vector3, Vector6};
use rand::RngExt;
use std::path::Path;

fn parse(text: &str) -> RobotFile {
    RobotFile::parse("robot.toml", text, Path::new("")).unwrap()
}

fn row(alpha: f64, a: f64, d: f64, offset: f64) -> DhParameters {
    DhParameters { alpha: alpha.to_radians(), a, d, offset: offset.to_radians() }
}

fn assert_same(a: &Robot, b: &Robot, seed: u64) {
    let mut random = rng(seed);
    assert_eq!(a.joints.len(), b.joints.len());
    for _ in 0..20 {
        let q: Vec<f64> = a.joints.iter().map(|_| random.random_range(-2.0..2.0)).collect();
        let difference = a.tool_pose(&q).unwrap().to_homogeneous() - b.tool_pose(&q).unwrap().to_homogeneous();
        assert!(difference.amax() < 1e-12, "{difference}");
    }
}

#[test]
fn the_file_of_the_kr125_is_the_published_robot() {
    let file = parse(KR125);
    let published = kr125().with_tool(Isometry3::translation(0.0, 0.0, 0.3));
    assert_same(&file.robot, &published, 1);
    assert_eq!(file.robot.name, "KR 125");
    assert_eq!(file.robot.joints[4].name, "A5");
    assert_eq!(file.springs.unwrap(), Springs::linear(&STIFFNESS));
    assert_eq!(file.payload.mass, 12.0);
    assert_eq!(file.payload.bias[3], 1.5);
    assert_eq!((file.noise.translation, file.noise.moment), (20e-6, 0.5));
    assert_eq!((file.compensation.period, file.compensation.order), (0.004, FilterOrder::First));
    // The sensor stands 0.25 m above the tool point.
    let ForceSensor { pose, force_range, .. } = file.sensor.unwrap();
    assert!((pose.translation.vector - Vector3::new(0.0, 0.0, -0.25)).amax() < 1e-15);
    assert_eq!(force_range, 2000.0);
}

#[test]
fn standard_parameters_are_told_from_modified_ones() {
    let joints = "[[joint]]\na = 0.3\nd = 0.1\nalpha_deg = 90\n[[joint]]\na = 0.2\noffset_deg = -30\n";
    let rows = [row(90.0, 0.3, 0.1, 0.0), row(0.0, 0.2, 0.0, -30.0)];
    let standard = parse(&format!("convention = \"standard\"\n{joints}"));
    let modified = parse(&format!("convention = \"modified\"\n{joints}"));
    assert_same(&standard.robot, &Robot::from_standard_dh("", &rows), 2);
    assert_same(&modified.robot, &Robot::from_modified_dh("", &rows), 3);
    assert!(standard.springs.is_none() && standard.sensor.is_none());
}

#[test]
fn springs_are_linear_stiffening_or_with_lost_motion() {
    let file = parse(
        "convention = \"modified\"\n[[joint]]\nstiffness = 1e5\n[[joint]]\nstiffness = 2e5\ncubic = 1e9\n\
         [[joint]]\nstiffness = 3e5\ngap = 2.9e-4\nengaged = 30\n",
    );
    let expected = vec![
        JointSpring::linear(1e5),
        JointSpring::Stiffening { stiffness: 2e5, cubic: 1e9 },
        JointSpring::Backlash { stiffness: 3e5, gap: 2.9e-4, engaged: 30.0 },
    ];
    assert_eq!(file.springs.unwrap().joints, expected);
}

#[test]
fn links_yield_by_the_compliances_that_their_joints_give() {
    let file = parse(
        "convention = \"modified\"\n[[joint]]\nstiffness = 1e5\nlink_compliance = [0, 2e-8, 0, 0, 0, 3e-7]\n\
         [[joint]]\na = 1\nstiffness = 2e5\n",
    );
    let springs = file.springs.unwrap();
    assert_eq!(springs.links[0], Matrix6::from_diagonal(&Vector6::new(0.0, 2e-8, 0.0, 0.0, 0.0, 3e-7)));
    assert_eq!(springs.links[1], Matrix6::zeros());
    // 100 N across an arm of 1 m: the first joint and its link turn, the link also gives way.
    let load = Vector6::new(0.0, 100.0, 0.0, 0.0, 0.0, 0.0);
    let moved = Deformation::linear(&file.robot, &springs, &[0.0, 0.0], &load).unwrap().tool;
    assert!((moved[1] - (100.0 / 1e5 + 100.0 * 2e-8 + 100.0 * 3e-7)).abs() < 1e-15, "{moved}");
    assert!(parse("convention = \"modified\"\n[[joint]]\nstiffness = 1e5\n").springs.unwrap().links.is_empty());
}

/// The KR 125 as URDF: each origin is the placement of a joint, in meters and roll, pitch, yaw.
fn urdf() -> String {
    let mut links = String::from("<link name=\"base\"/><link name=\"world_box\"/>");
    let mut joints =
        String::from("<joint name=\"box\" type=\"fixed\"><parent link=\"base\"/><child link=\"world_box\"/></joint>");
    let half = std::f64::consts::FRAC_PI_2;
    let placements = [
        ([0.0, 0.0, 0.75], [0.0; 3]),
        ([0.35, 0.0, 0.0], [-half, 0.0, 0.0]),
        ([1.25, 0.0, 0.0], [0.0; 3]),
        ([-0.055, 1.1, 0.0], [-half, 0.0, 0.0]),
        ([0.0; 3], [half, 0.0, 0.0]),
        ([0.0, 0.23, 0.0], [-half, 0.0, 0.0]),
    ];
    let mut parent = "base".to_owned();
    for (i, ([x, y, z], [roll, pitch, yaw])) in placements.iter().enumerate() {
        let child = format!("link_{}", i + 1);
        links += &format!("<link name=\"{child}\"/>");
        joints += &format!(
            "<joint name=\"A{}\" type=\"revolute\"><origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>\
             <parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"1\"/></joint>",
            i + 1
        );
        parent = child;
    }
    links += "<link name=\"tool0\"/>";
    joints += &format!(
        "<joint name=\"flange\" type=\"fixed\"><origin xyz=\"0 0 0.3\" rpy=\"0 0 0\"/>\
         <parent link=\"{parent}\"/><child link=\"tool0\"/></joint>"
    );
    format!("<?xml version=\"1.0\"?><robot name=\"kr125\">{links}{joints}</robot>")
}

#[test]
fn a_urdf_description_is_the_same_robot() {
    let described = Robot::from_urdf(&urdf(), Some("base"), Some("tool0")).unwrap();
    // URDF has no offset of a joint: the second starts at −90°.
    let mut published = parse(KR125).robot;
    published.joints[1].offset = 0.0;
    assert_same(&described, &published, 4);
    assert_eq!(described.joints[2].name, "A3");
    // Base alone is clear, the tip is not: a box hangs on the base too.
    let message = Robot::from_urdf(&urdf(), None, None).unwrap_err().to_string();
    assert!(message.contains("tip link") && message.contains("world_box") && message.contains("tool0"), "{message}");
    assert_same(&Robot::from_urdf(&urdf(), None, Some("tool0")).unwrap(), &published, 5);
    for (base, tip, said) in [
        (Some("nowhere"), Some("tool0"), "no link `nowhere`"),
        (Some("link_3"), Some("world_box"), "is not connected to link `link_3`"),
        (Some("base"), Some("base"), "without a movable joint"),
    ] {
        let message = Robot::from_urdf(&urdf(), base, tip).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn urdf_joints_that_slide_slide_and_others_are_refused() {
    let with = |joint: &str| {
        let text = format!(
            "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" {joint}<parent link=\"a\"/>\
             <child link=\"b\"/><limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>"
        );
        Robot::from_urdf(&text, None, None)
    };
    let slide = with("type=\"prismatic\"><axis xyz=\"0 3 4\"/><origin xyz=\"1 0 0\"/>").unwrap();
    assert_eq!(slide.joints[0].kind, JointKind::Prismatic);
    let moved = slide.tool_pose(&[0.5]).unwrap().translation.vector;
    assert!((moved - Vector3::new(1.0, 0.3, 0.4)).amax() < 1e-15);
    for (joint, said) in [
        ("type=\"floating\"><axis xyz=\"0 0 1\"/>", "several degrees of freedom"),
        ("type=\"revolute\"><axis xyz=\"0 0 0\"/>", "no direction"),
        ("type=\"revolute\"><axis xyz=\"0 0 1\"/><origin xyz=\"nan 0 0\"/>", "not finite"),
        ("type=\"revolute\"><axis xyz=\"0 0 1\"/><mimic joint=\"k\"/>", "mimics"),
        ("type=\"revolute\"><axis xyz=\"0 0 1\"", "not a URDF"),
        ("type=\"revolute\"><axis xyz=\"0 1\"/>", "`xyz` of <axis> is not three numbers, at 1:"),
        ("type=\"revolute\"><origin rpy=\"0 0 up\"/>", "`rpy` of <origin> is not three numbers"),
        ("type=\"spiral\">", "`spiral` is not a joint type"),
        (">", "<joint> without `type`"),
    ] {
        let message = with(joint).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn a_file_with_a_urdf_description_takes_it_from_beside_itself() {
    let folder = std::env::temp_dir().join(format!("bracketry_urdf_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("kr125.urdf"), urdf()).unwrap();
    let file = folder.join("robot.toml");
    let text = "urdf = \"kr125.urdf\"\nbase = \"base\"\ntip = \"tool0\"\n";
    std::fs::write(&file, text.to_owned() + &"[[joint]]\nstiffness = 1e6\n".repeat(6)).unwrap();
    let read = RobotFile::read(&file).unwrap();
    assert_eq!(read.robot.name, "kr125");
    assert_eq!(read.springs.unwrap(), Springs::linear(&[1e6; 6]));
    std::fs::write(&file, text.to_owned() + &"[[joint]]\nstiffness = 1e6\n".repeat(5)).unwrap();
    let message = RobotFile::read(&file).unwrap_err().to_string();
    assert!(message.contains("5 [[joint]] entries for 6 joints") && message.contains("A1, A2"), "{message}");
    std::fs::write(&file, "urdf = \"kr125.urdf\"\n").unwrap();
    let message = RobotFile::read(&file).unwrap_err().to_string();
    assert!(message.contains("robot.toml:1:8: kr125.urdf: the tip link is ambiguous"), "{message}");
    std::fs::remove_file(folder.join("kr125.urdf")).unwrap();
    let message = RobotFile::read(&file).unwrap_err().to_string();
    assert!(message.contains("kr125.urdf: cannot be read"), "{message}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn errors_name_place_and_remedy() {
    let head = "convention = \"modified\"\n[[joint]]\n";
    for (text, said) in [
        ("name = \"r\"\n", &["convention = \"modified\""][..]),
        ("convention = \"classic\"\n[[joint]]\na = 1\n", &["robot.toml:1:14", "not a convention", "standard"]),
        ("convention = \"modified\"\n", &["has no joints"]),
        (&format!("{head}aa = 0.3\n"), &["robot.toml:3:1", "unknown key `aa`", "alpha_deg"]),
        (&format!("{head}a = 350\n"), &["robot.toml:3:5", "350", "not mm"]),
        (&format!("{head}alpha_deg = -1.5708\n"), &["robot.toml:3:13", "looks like radians", "alpha_deg = -90"]),
        (&format!("{head}a = \"0.3\"\n"), &["robot.toml:3:5", "must be a number"]),
        (&format!("{head}a = nan\n"), &["robot.toml:3:5", "not a finite number"]),
        (&format!("{head}stiffness = -3e5\n"), &["robot.toml:3:13", "N·m/rad"]),
        (&format!("{head}cubic = 3e5\n"), &["robot.toml:3:1", "without `stiffness`"]),
        (&format!("{head}link_compliance = [0, 0, 0, 0, 0, 0]\n"), &["robot.toml:3:1", "without `stiffness`"]),
        (&format!("{head}stiffness = 3e5\nlink_compliance = [1e-8]\n"), &["robot.toml:4:19", "list of 6 numbers"]),
        (
            &format!("{head}stiffness = 3e5\nlink_compliance = [1e8, 0, 0, 0, 0, 0]\n"),
            &["robot.toml:4:20", "1/k of a stiffness"],
        ),
        (&format!("{head}a = 1\n[compensation]\nlag = 12\n"), &["robot.toml:5:7", "0.012"]),
        (&format!("{head}a = 1\n[compensation]\nstiffness_error = 30\n"), &["robot.toml:5:19", "10 % is 0.1"]),
        (&format!("{head}stiffness = 3e5\ngap = 1e-4\n"), &["robot.toml:4:1", "`gap` without `engaged`"]),
        (&format!("{head}stiffness = 3e5\ngap = 0.3\nengaged = 5\n"), &["robot.toml:4:7", "2.9e-4"]),
        (&format!("{head}stiffness = 3e5\n[[joint]]\na = 1\n"), &["joint 2 (joint_2) has no stiffness"]),
        (&format!("{head}a = 1\n[tool]\nposition = [0, 1]\n"), &["robot.toml:5:12", "list of 3 numbers"]),
        (&format!("{head}a = 1\n[sensor]\nforce_range = 10\n"), &["no `moment_range`"]),
        (&format!("{head}a = 1\n[noise]\ntranslation = 20\n"), &["robot.toml:5:15", "20e-6"]),
        (&format!("{head}a = 1\n[compensation]\nperiod = 4\n"), &["robot.toml:5:10", "0.004"]),
        (&format!("{head}a = 1\n[compensation]\ncutoff = 300\n"), &["robot.toml:5:10", "half the sampling rate"]),
        (&format!("{head}a = 1\n[compensation]\norder = 1.5\n"), &["robot.toml:5:9", "not a whole number"]),
        (&format!("{head}a = 1\ntool = 3\n"), &["unknown key `tool`"]),
        (&format!("{head}a = = 1\n"), &["robot.toml:3:5", "TOML syntax"]),
        ("urdf = \"a.urdf\"\nconvention = \"modified\"\n", &["robot.toml:2:1", "both"]),
        ("convention = \"modified\"\nbase = \"b\"\n[[joint]]\na = 1\n", &["robot.toml:2:1", "URDF"]),
        ("joint = 3\nconvention = \"modified\"\n", &["robot.toml:1:9", "list of tables"]),
    ] {
        let message = RobotFile::parse("robot.toml", text, Path::new("")).unwrap_err().to_string();
        for part in said {
            assert!(message.contains(part), "{text}\n{message}");
        }
    }
    let message = RobotFile::read("/nowhere/robot.toml").unwrap_err().to_string();
    assert!(message.contains("cannot be read") && message.contains("check the path"), "{message}");
}

#[test]
fn mutilated_files_are_read_or_refused() {
    let mut random = rng(6);
    let texts = [KR125.to_owned(), urdf()];
    let mut refused = 0;
    for round in 0..600 {
        let mut characters: Vec<char> = texts[round % 2].chars().collect();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..characters.len());
            match random.random_range(0..3) {
                0 => {
                    characters.remove(at);
                }
                1 => characters[at] = ['=', '"', '9', '-', '[', '<', 'µ', '\n'][random.random_range(0..8)],
                _ => characters.truncate(at.max(1)),
            }
        }
        let text: String = characters.into_iter().collect();
        let failed = if round % 2 == 0 {
            RobotFile::parse("robot.toml", &text, Path::new("")).map(|f| f.robot).map_err(|e| e.to_string())
        } else {
            Robot::from_urdf(&text, Some("base"), Some("tool0")).map_err(|e| e.to_string())
        };
        match failed {
            Ok(robot) => assert!(robot.tool_pose(&vec![0.1; robot.joints.len()]).is_ok()),
            Err(message) => {
                assert!(!message.is_empty());
                refused += 1;
            }
        }
    }
    assert!(refused > 200, "{refused}");
}

#[test]
fn other_springs_are_written_into_the_file_and_nothing_else_changes() {
    let joints = vec![
        JointSpring::linear(1.234_567e6),
        JointSpring::Backlash { stiffness: 4e5, gap: 2.9e-4, engaged: 30.0 },
        JointSpring::Stiffening { stiffness: 9.1e5, cubic: 1e10 },
        JointSpring::linear(3.5e5),
        JointSpring::linear(3.6e5),
        JointSpring::linear(1e9 / 3.0),
    ];
    let changed = with_springs("kr125.toml", KR125, &Springs::of_joints(joints.clone())).unwrap();
    let (before, after) = (parse(KR125), parse(&changed));
    assert_eq!(RobotFile { springs: None, ..after.clone() }, RobotFile { springs: None, ..before });
    let written = after.springs.unwrap().joints;
    assert_eq!(written[0], JointSpring::linear(1.23457e6));
    assert_eq!(written[1..5], joints[1..5]);
    assert_eq!(written[5], JointSpring::linear(333_333_000.0));
    // Comments stay.
    assert!(changed.contains("# N·m/rad") && changed.contains("# Craig: "));
    // A joint without a stiffness gets one.
    let bare = "convention = \"modified\"\n[[joint]]\na = 1 # m\n[tool]\nposition = [0, 0, 1]";
    let sprung = with_springs("r.toml", bare, &Springs::linear(&[5e5])).unwrap();
    assert_eq!(parse(&sprung).springs.unwrap(), Springs::linear(&[5e5]));
    // Joints in braces get theirs between them; links keep their compliance.
    let braces = "convention = \"modified\"\njoint = [\n  { a = 1.0 }, # first\n  { d = 1, stiffness = 3e5, link_compliance = [1e-8, 0, 0, 0, 0, 0], },\n]\n";
    let two = Springs::of_joints(vec![JointSpring::linear(5e5), joints[1]]);
    let sprung = with_springs("r.toml", braces, &two).unwrap();
    let written = parse(&sprung).springs.unwrap();
    assert_eq!((written.joints, written.links[1][(0, 0)]), (two.joints, 1e-8));
    assert!(sprung.contains("# first"), "{sprung}");
    // Beside a URDF description the joints are added.
    let described =
        with_springs("r.toml", "urdf = \"r.urdf\"\n[tool]\nposition = [0, 0, 1]", &Springs::of_joints(joints)).unwrap();
    assert_eq!(described.matches("[[joint]]\nstiffness").count(), 6);
    assert!(described.contains("gap = 0.00029\nengaged = 30.0"));
    for (text, springs) in [
        ("convention = \"modified\"\n", Springs::linear(&[5e5])),
        ("joint = [{}]\nconvention = \"modified\"\n", Springs::linear(&[5e5])),
        (bare, Springs::linear(&[5e5, 5e5])),
    ] {
        let message = with_springs("r.toml", text, &springs).unwrap_err().to_string();
        assert!(message.contains("[[joint]]"), "{message}");
    }
}
