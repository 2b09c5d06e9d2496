//! Controllers at the end of a pipe: the protocol, and peers that fail.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{bracketry, code, file, json, scratch};
use serde_json::{Value, json};

const MODEL: &str = "states = ['x', 'v']\ninputs = ['a']\nparameters = { m = 1 }\ndynamics = { x = 'v', v = 'a/m' }\n";
const PROBLEM: &str = "model = 'mass.toml'\nlive_parameters = ['m']\nhorizon = { steps = 20, dt = 0.1 }\n\
    cost = { stage = '(x - r)^2 + 0.1*v^2 + 0.01*a^2' }\nreferences = { r = 0 }\n\
    constraints = { a = { min = -1, max = 1 } }\nsolve = { method = 'rti' }\nrun = { x0 = { x = 1 }, steps = 40 }\n";

/// The command at the other end of a pipe.
struct Peer {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    hello: Value,
}

impl Peer {
    fn start(problem: &str, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_bracketry"))
            .args(["control", problem, "--live"])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take(), BufReader::new(child.stdout.take().unwrap()));
        let mut peer = Self { child, to, from, hello: Value::Null };
        peer.hello = peer.receive();
        assert_eq!((&peer.hello["type"], &peer.hello["protocol"]), (&"hello".into(), &1.into()));
        peer
    }

    fn send(&mut self, line: &str) {
        self.to.as_mut().unwrap().write_all(format!("{line}\n").as_bytes()).unwrap();
    }

    fn receive(&mut self) -> Value {
        let mut line = String::new();
        assert!(self.from.read_line(&mut line).unwrap() > 0, "the command has ended");
        serde_json::from_str(&line).unwrap()
    }

    fn ask(&mut self, message: &Value) -> Value {
        self.send(&message.to_string());
        self.receive()
    }

    /// Exit code and what was said on standard error.
    fn end(mut self) -> (i32, String) {
        self.to = None;
        drop(self.from);
        let o = self.child.wait_with_output().unwrap();
        (o.status.code().unwrap(), String::from_utf8(o.stderr).unwrap())
    }
}

fn problem(dir: &Path) -> String {
    file(dir, "mass.toml", MODEL);
    file(dir, "problem.toml", PROBLEM)
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

#[test]
fn a_loop_over_the_pipe_is_the_one_of_the_command_bit_for_bit() {
    let dir = scratch("live_same");
    let problem = problem(&dir);
    json(&["control", &problem, "--json", "--out", dir.join("inside").to_str().unwrap()]);
    let table = fs::read_to_string(dir.join("inside/closed_loop.csv")).unwrap();
    let mut rows = table.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let (x, v, a) = (column("x"), column("v"), column("a"));
    let mut peer = Peer::start(&problem, &["--out", dir.join("live").to_str().unwrap()]);
    assert_eq!(peer.hello["measured"], json!(["x", "v"]));
    let mut samples = 0;
    for row in rows.take(40) {
        let read = |i: usize| row[i].parse::<f64>().unwrap();
        let answer = peer.ask(&json!({"y": [read(x), read(v)], "t": 0.1 * f64::from(samples)}));
        assert_eq!(
            (&answer["type"], &answer["status"], &answer["source"]),
            (&"input".into(), &"solved".into(), &"program".into())
        );
        assert_eq!(number(&answer["u"][0]), read(a), "sample {samples}");
        samples += 1;
    }
    assert_eq!(samples, 40);
    let end = peer.ask(&json!({"type": "end"}));
    assert_eq!((&end["type"], &end["reason"], &end["samples"]), (&"end".into(), &"end".into(), &40.into()));
    let (code, said) = peer.end();
    assert_eq!((code, said.as_str()), (0, ""));
    let kept = fs::read_to_string(dir.join("live/closed_loop.csv")).unwrap();
    assert_eq!(kept.lines().next(), Some("t,x,v,a"));
    assert_eq!(kept.lines().count(), 41);
}

#[test]
fn what_a_peer_sends_wrong_is_refused_and_changes_nothing() {
    let dir = scratch("live_lies");
    let problem = problem(&dir);
    let (mut honest, mut liar) = (Peer::start(&problem, &[]), Peer::start(&problem, &[]));
    for k in 0..10 {
        let message = json!({"y": {"x": 1.0 - 0.05 * f64::from(k), "v": 0.1}, "t": 0.1 * f64::from(k)});
        let mut wrong = vec![
            ("this is no JSON".to_owned(), "json"),
            (json!({"y": [1]}).to_string(), "length"),
            (json!({"y": [1, 2, 3]}).to_string(), "length"),
            (json!({"y": {"q": 1}}).to_string(), "name"),
            (json!({"y": [1, 0], "t": "soon"}).to_string(), "message"),
            (json!({"type": "set", "references": {"q": 1}}).to_string(), "name"),
            (json!({"type": "set", "bounds": {"a": [2, 1]}}).to_string(), "value"),
            (json!({"type": "set", "parameters": {"q": 1}}).to_string(), "name"),
            (json!({"type": "set", "targets": {"x": 1}}).to_string(), "name"),
            (json!({"type": "reset", "x0": [1]}).to_string(), "length"),
            (json!({"type": "reset", "x0": [1, null]}).to_string(), "value"),
            // Numbers that are none are no bounds and no times either.
            ("{\"type\": \"set\", \"bounds\": {\"a\": [NaN, 1]}}".to_owned(), "value"),
            ("{\"type\": \"set\", \"bounds\": {\"a\": [Infinity, null]}}".to_owned(), "value"),
            ("{\"type\": \"set\", \"bounds\": {\"a\": [null, -Infinity]}}".to_owned(), "value"),
            ("{\"type\": \"set\", \"parameters\": {\"m\": NaN}}".to_owned(), "value"),
            ("{\"type\": \"set\", \"references\": {\"r\": [0, NaN]}}".to_owned(), "value"),
            ("{\"y\": [1, 0], \"t\": NaN}".to_owned(), "time"),
            ("{\"y\": [1, 0], \"t\": -Infinity}".to_owned(), "time"),
            ("{\"y\": [1e999, 0]}".to_owned(), "json"),
            ("{\"y\": [1, 0]} {\"y\": [1, 0]}".to_owned(), "json"),
            (json!({"y": {"größe": 1}}).to_string(), "name"),
            (json!({"type": "set", "references": {"r": []}}).to_string(), "length"),
            // What is good in a message that is refused is not done.
            (
                json!({"type": "set", "references": {"r": 3}, "parameters": {"m": 5}, "bounds": {"a": [2, 1]}})
                    .to_string(),
                "value",
            ),
            (json!({"type": "set", "bounds": {"a": [-0.1, 0.1]}, "targets": {"x": 1}}).to_string(), "name"),
            ("[".repeat(10_000), "json"),
            ("[1, 2]".to_owned(), "json"),
            ("{\"y\": [1,".to_owned(), "json"),
            (json!({"y": [1], "z": 2}).to_string(), "message"),
            (json!({"y": "1"}).to_string(), "message"),
            (json!({}).to_string(), "message"),
            (json!({"type": 3}).to_string(), "message"),
            (json!({"type": "jump"}).to_string(), "message"),
            (json!({"type": "end", "y": [1]}).to_string(), "message"),
            (json!({"type": "hello", "protocol": 99}).to_string(), "protocol"),
            (format!("{{\"y\": [{}]}}", "1,".repeat(1 << 20)), "json"),
        ];
        if k > 0 {
            wrong.extend([
                (json!({"y": [1, 0], "t": 0.1 * f64::from(k - 1)}).to_string(), "time"),
                (json!({"y": [1, 0], "t": 1e9}).to_string(), "time"),
            ]);
        }
        for (line, code) in wrong {
            liar.send(&line);
            let answer = liar.receive();
            assert_eq!((&answer["type"], &answer["code"]), (&"error".into(), &code.into()), "{answer}");
        }
        assert_eq!(liar.ask(&message)["u"], honest.ask(&message)["u"], "sample {k}");
    }
}

/// What some languages write in place of numbers that JSON does not have: it is no measurement, no time, and as a bound what it says.
#[test]
fn numbers_that_are_not_finite_are_read_as_they_are() {
    let dir = scratch("live_not_finite");
    let mut peer = Peer::start(&problem(&dir), &[]);
    for y in ["null", "NaN", "nan", "Infinity", "-Infinity", "\"NaN\"", "\"Infinity\"", "\"-Infinity\""] {
        peer.send(&format!("{{\"y\": [1.5, {y}]}}"));
        let answer = peer.receive();
        assert_eq!((&answer["type"], &answer["reason"]), (&"input".into(), &"measurement".into()), "{y}: {answer}");
    }
    for (line, code) in [
        ("{\"y\": [1.5, 0], \"t\": nan}", "time"),
        ("{\"type\": \"set\", \"bounds\": {\"a\": [\"Infinity\", null]}}", "value"),
        ("{\"type\": \"set\", \"bounds\": {\"a\": [null, \"-Infinity\"]}}", "value"),
    ] {
        peer.send(line);
        assert_eq!(peer.receive()["code"], code, "{line}");
    }
    for bounds in ["[-Infinity, Infinity]", "[\"-Infinity\", \"Infinity\"]", "[null, Infinity]"] {
        peer.send(&format!("{{\"type\": \"set\", \"bounds\": {{\"a\": {bounds}}}}}"));
        assert_eq!(peer.receive()["type"], "done", "{bounds}");
    }
    // In quotes, it is a name.
    peer.send("{\"y\": {\"NaN\": NaN}}");
    let refused = peer.receive();
    assert_eq!(refused["code"], "name");
    assert!(refused["message"].as_str().unwrap().contains("`NaN`"), "{refused}");
}

#[test]
fn long_and_broken_lines_do_not_hide_those_that_follow() {
    let dir = scratch("live_lines");
    let mut peer = Peer::start(&problem(&dir), &[]);
    let mut lines = vec![b'x'; 3 << 20];
    lines.extend(b"\n\xff\xfe\n\n \n{\"y\": [1, 0]}\n{\"y\": [0.9, 0]}");
    peer.to.take().unwrap().write_all(&lines).unwrap();
    for part in ["longer than 1 MiB", "not UTF-8"] {
        let refused = peer.receive();
        assert_eq!((&refused["type"], &refused["code"]), (&"error".into(), &"json".into()));
        assert!(refused["message"].as_str().unwrap().contains(part), "{refused}");
    }
    for sample in 0..2 {
        let answer = peer.receive();
        assert_eq!((&answer["type"], &answer["sample"]), (&"input".into(), &sample.into()));
    }
    assert_eq!(peer.receive()["reason"], "closed");
}

#[test]
fn a_lost_measurement_gets_the_policy_and_is_counted() {
    let dir = scratch("live_lost");
    let mut peer = Peer::start(&problem(&dir), &[]);
    let first = peer.ask(&json!({"y": [1, 0], "predict": true}));
    let planned = first["prediction"]["u"][1][0].clone();
    peer.send("{\"y\": [NaN, NaN]}");
    let lost = peer.receive();
    assert_eq!(
        (&lost["status"], &lost["reason"], &lost["source"]),
        (&"fallback".into(), &"lost_sample".into(), &"plan".into())
    );
    assert_eq!(lost["u"][0], planned);
    let half = peer.ask(&json!({"y": [0.9, null]}));
    assert_eq!(half["reason"], "measurement");
    let late = peer.ask(&json!({"y": [0.8, -0.2], "t": 10.0}));
    assert_eq!((&late["sample"], &late["missed"]), (&3.into(), &0.into()), "the first time is that of the next sample");
    let jumped = peer.ask(&json!({"y": [0.7, -0.2], "t": 10.4}));
    assert_eq!((&jumped["sample"], &jumped["missed"]), (&7.into(), &3.into()));
    peer.ask(&json!({"type": "end"}));
    let (code, said) = peer.end();
    assert_eq!(code, 1);
    assert!(said.contains("2 had no solution"), "{said}");
}

#[test]
fn changes_take_effect_and_a_reset_starts_again() {
    let dir = scratch("live_changes");
    let mut peer = Peer::start(&problem(&dir), &[]);
    let push = |peer: &mut Peer, x: f64| number(&peer.ask(&json!({"y": [x, 0]}))["u"][0]);
    assert!(push(&mut peer, 0.0).abs() < 1e-6);
    assert_eq!(peer.ask(&json!({"type": "set", "references": {"r": 1}}))["type"], "done");
    assert!(push(&mut peer, 0.0) > 0.9);
    peer.ask(&json!({"type": "set", "bounds": {"a": [-0.5, 0.5]}, "parameters": {"m": 2}}));
    assert!((push(&mut peer, 0.0) - 0.5).abs() < 1e-6);
    peer.ask(&json!({"type": "set", "references": {"r": [0, 0, 0]}, "bounds": {"a": [null, 0.7]}}));
    assert!(push(&mut peer, 0.0).abs() < 1e-3);
    assert_eq!(peer.ask(&json!({"type": "reset", "x0": {"x": 0.5, "v": 0}}))["type"], "done");
    let answer = peer.ask(&json!({"y": [0.5, 0]}));
    assert_eq!(answer["sample"], 0);
    let prediction = peer.ask(&json!({"type": "predict"}));
    assert_eq!((&prediction["type"], prediction["x"].as_array().unwrap().len()), (&"prediction".into(), 21));
    assert_eq!(peer.ask(&json!({"type": "heartbeat"}))["type"], "heartbeat");
}

#[test]
fn a_peer_that_stalls_gets_the_policy_at_every_deadline_and_is_left_in_the_end() {
    let dir = scratch("live_stalled");
    let mut peer = Peer::start(&problem(&dir), &["--deadline", "0.05", "--timeout", "1"]);
    peer.ask(&json!({"y": [1, 0]}));
    let (mut policy, mut last) = (0, Value::Null);
    while last["type"] != "end" {
        last = peer.receive();
        policy += usize::from(last["reason"] == "lost_sample");
    }
    assert!(policy >= 3, "{policy} inputs without a measurement");
    assert_eq!((&last["reason"], last["u"].as_array().unwrap().len()), (&"timeout".into(), 1));
    let (code, said) = peer.end();
    assert_eq!(code, 1);
    assert!(said.contains("--timeout"), "{said}");
}

#[test]
fn a_silent_peer_hears_signs_of_life() {
    let dir = scratch("live_heartbeat");
    let mut peer = Peer::start(&problem(&dir), &["--heartbeat", "0.05"]);
    for _ in 0..3 {
        assert_eq!(peer.receive()["type"], "heartbeat");
    }
}

#[test]
fn a_peer_that_is_not_silent_hears_none() {
    let dir = scratch("live_no_heartbeat");
    let mut peer = Peer::start(&problem(&dir), &["--heartbeat", "1"]);
    for k in 0..30 {
        assert_eq!(peer.ask(&json!({"y": [1, 0]}))["type"], "input", "sample {k}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn no_measurement_is_due_before_the_first() {
    let dir = scratch("live_due");
    let mut peer = Peer::start(&problem(&dir), &["--deadline", "0.05"]);
    let silent = |peer: &mut Peer, what: &str| {
        std::thread::sleep(Duration::from_millis(250));
        assert_eq!(peer.ask(&json!({"type": "heartbeat"}))["type"], "heartbeat", "{what}");
    };
    silent(&mut peer, "at the start");
    peer.ask(&json!({"y": [1, 0]}));
    peer.send("{\"type\": \"reset\"}");
    // The policy may have been faster than the reset.
    while peer.receive()["type"] != "done" {}
    silent(&mut peer, "after a reset");
}

#[test]
fn what_has_been_sent_without_an_end_of_line_is_answered() {
    let dir = scratch("live_cut");
    let problem = problem(&dir);
    for (last, kind) in [("{\"y\": [1, 0]}", "input"), ("{\"y\": [1, ", "error")] {
        let mut peer = Peer::start(&problem, &[]);
        peer.to.take().unwrap().write_all(last.as_bytes()).unwrap();
        assert_eq!(peer.receive()["type"], kind);
        let end = peer.receive();
        assert_eq!((&end["type"], &end["reason"]), (&"end".into(), &"closed".into()));
        assert_eq!(peer.end().0, 1);
    }
}

#[test]
fn a_peer_that_is_killed_ends_the_command() {
    let dir = scratch("live_killed");
    let problem = problem(&dir);
    let mut closed = Peer::start(&problem, &[]);
    closed.ask(&json!({"y": [1, 0]}));
    let (code, said) = closed.end();
    assert_eq!(code, 1);
    assert!(said.contains("closed the connection"), "{said}");
    // Both ends of the pipe are gone at once, with answers on the way.
    let mut gone = Peer::start(&problem, &[]);
    for _ in 0..50 {
        gone.send("{\"y\": [1, 0]}");
    }
    assert_eq!(gone.end().0, 1);
}

#[test]
fn a_peer_that_does_not_read_ends_the_command() {
    let dir = scratch("live_unread");
    let mut peer = Peer::start(&problem(&dir), &["--timeout", "1"]);
    let mut to = peer.to.take().unwrap();
    // The pipe fills up: some writes fail once the command has ended.
    let writer = std::thread::spawn(move || while to.write_all(b"{\"y\": [1, 0], \"predict\": true}\n").is_ok() {});
    let mut waited = 0;
    let status = loop {
        if let Some(status) = peer.child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(Duration::from_millis(50));
        waited += 1;
        assert!(waited < 2400, "the command hangs");
    };
    assert_eq!(status.code(), Some(1));
    writer.join().unwrap();
}

/// A peer that closes the end that it reads, and goes on with nothing, is noticed long before the time-out, which is 60 s.
#[cfg(unix)]
#[test]
fn a_peer_that_closes_its_reading_end_is_noticed_at_once() {
    let dir = scratch("live_closed_reader");
    let mut peer = Peer::start(&problem(&dir), &[]);
    peer.ask(&json!({"y": [1, 0]}));
    let started = Instant::now();
    drop(peer.from);
    let o = peer.child.wait_with_output().unwrap();
    assert!(started.elapsed() < Duration::from_secs(10), "{:?}", started.elapsed());
    assert_eq!(o.status.code(), Some(1));
    assert!(String::from_utf8(o.stderr).unwrap().contains("does not read"));
    drop(peer.to);
}

/// Samples that take longer than the sampling period are counted: with a period of a nanosecond, all of them.
#[test]
fn samples_that_take_longer_than_the_period_are_counted() {
    let dir = scratch("live_late");
    file(&dir, "mass.toml", MODEL);
    let path = file(&dir, "problem.toml", &PROBLEM.replace("dt = 0.1", "dt = 1e-9"));
    let mut peer = Peer::start(&path, &[]);
    for _ in 0..3 {
        peer.ask(&json!({"y": [1, 0]}));
    }
    let end = peer.ask(&json!({"type": "end"}));
    assert_eq!((&end["late"]["samples"], &end["late"]["share"]), (&3.into(), &1.0.into()));
    assert!(number(&end["late"]["longest_ms"]) > 1e-6);
    let (code, said) = peer.end();
    assert!(code == 0 && said.contains("3 samples (100.0 %) took longer to solve"), "{code} {said}");
}

/// A problem without `[run]` is one for a controller of a plant of one's own; to run it, a start is missing.
#[test]
fn a_problem_without_a_run_is_for_live_controllers() {
    let dir = scratch("live_no_run");
    file(&dir, "mass.toml", MODEL);
    let text = PROBLEM.split("run = ").next().unwrap();
    let path = file(&dir, "problem.toml", text);
    let o = bracketry(&["control", &path]);
    let said = String::from_utf8(o.stderr.clone()).unwrap();
    assert!(code(&o) == 2 && said.contains("[run]") && said.contains("--live"), "{said}");
    let mut open = Peer::start(&path, &[]);
    let given = file(&dir, "given.toml", &PROBLEM.replace("x0 = { x = 1 }", "x0 = { x = 1, v = 0.5 }"));
    let mut given = Peer::start(&given, &[]);
    for k in 0..5 {
        let y = json!({"y": [1.0 - 0.01 * f64::from(k), 0.5]});
        let [a, b] = [&mut open, &mut given].map(|peer| number(&peer.ask(&y)["u"][0]));
        assert!((a - b).abs() < 1e-6, "{k}: {a} {b}");
    }
}

#[test]
fn limits_that_mean_nothing_are_refused() {
    let dir = scratch("live_limits");
    let problem = problem(&dir);
    for arguments in [
        ["--deadline", "0.1"].as_slice(),
        &["--live", "--deadline", "0"],
        &["--live", "--timeout", "nan"],
        &["--live", "--heartbeat", "-1"],
    ] {
        let o = bracketry(&[&["control", problem.as_str()], arguments].concat());
        assert_eq!(code(&o), 2, "{arguments:?}");
        assert!(!String::from_utf8_lossy(&o.stderr).contains("unexpected"), "{arguments:?}");
    }
}

#[test]
fn the_command_writes_predictions_and_the_plan() {
    let dir = scratch("live_predictions");
    file(&dir, "mass.toml", MODEL);
    let problem =
        file(&dir, "problem.toml", &PROBLEM.replace("'rti'", "'plan'").replace("run =", "target = { x = 0 }\nrun ="));
    // After the end of its plan the mass drifts away from the target, which is a negative answer.
    assert_eq!(code(&bracketry(&["control", &problem, "--json", "--out", dir.join("out").to_str().unwrap()])), 1);
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(dir.join("out").join(name)).unwrap();
        text.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect()
    };
    let (plan, predictions, run) = (rows("plan.csv"), rows("predictions.csv"), rows("closed_loop.csv"));
    assert_eq!(plan.len(), 21);
    for (sample, now) in run.iter().take(20).enumerate() {
        let mut own = predictions.iter().filter(|row| row[0] == sample as f64);
        let first = own.next().unwrap();
        assert_eq!(first[1..], now[..first.len() - 1], "sample {sample}: time, states and input are those of the run");
        assert_eq!(own.count(), 20 - sample, "the horizon shrinks");
    }
}

/// A process without the package swings a cart-pole up: problem file and program of the guide.
#[test]
fn the_cart_pole_of_the_guide_is_swung_up_and_held_over_the_pipe() {
    let guide = fs::read_to_string(crate::common::root().join("docs/live.md")).unwrap();
    let block = |language: &str, first: &str| {
        let start = format!("```{language}\n{first}");
        format!("{first}{}", guide.split(&start).nth(1).unwrap().split("```").next().unwrap())
    };
    let dir = scratch("live_guide");
    file(&dir, "cart_pole.toml", &fs::read_to_string(crate::common::root().join("models/cart_pole.toml")).unwrap());
    file(&dir, "swing_up.toml", &block("toml", "# swing_up.toml"));
    // As for the plant of another engine that is stepped from Python.
    let ends = "pipe.wait()\nassert pipe.returncode == 0\n\
        assert abs(x[0]) < 0.05 and abs(x[1]) < 0.05 and max(map(abs, x[2:])) < 0.2, x\n";
    let file = file(&dir, "peer.py", &format!("{}{ends}", block("text", "import json, math")));
    let command = Path::new(env!("CARGO_BIN_EXE_bracketry")).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap();
    let path = std::env::join_paths([command.to_owned()].into_iter().chain(std::env::split_paths(&others))).unwrap();
    let o = Command::new("python3").arg(file).current_dir(&dir).env("PATH", path).output().unwrap();
    assert!(o.status.success(), "{}", String::from_utf8_lossy(&o.stderr));
}
