// The pages that are tried, of small problems.
import fs from "node:fs";
import path from "node:path";

/** Writes them into folders of `out` with `run`, which gets the arguments of the command and its allowed exit codes. */
export function pagesOf(root, out, run) {
  const guide = (name) => path.join(root, "docs/getting_started", name);
  const model = (name) => path.join(root, "models", name);
  const file = (folder, name) => path.join(out, folder, name);
  const pages = [];
  const add = (name, page, list, data, codes, hasFigures = true) => {
    run([...list, "--out", path.join(out, name)], codes);
    pages.push({ name, file: file(name, page), data, hasFigures });
  };
  // The beam, whose states are drawn as lines.
  const states = { r: ["r = position", 1], v: ["v", 1], th: ["th = angle", 1], w: ["w", 1] };
  const ball = ["--scenario", guide("ball_scenario.toml")];
  add("simulate", "simulation.html", ["simulate", guide("ball.toml"), ...ball], { file: file("simulate", "trajectory.csv"), columns: states });
  const noise = ["--noise", "position=0.0005,angle=0.0002", "--seed", "1"];
  run(["simulate", guide("felt.toml"), ...ball, ...noise, "--out", path.join(out, "measured")]);
  // Between samples the plant moves on smoothly.
  const loop = { r: ["r", 1], th: ["th", 1] };
  add("control", "control.html", ["control", guide("ball_problem.toml")], { file: file("control", "closed_loop.csv"), columns: loop }, [0, 1]);
  add("diagnose", "diagnosis.html", ["diagnose", guide("ball.toml"), file("measured", "measured.csv"), "--hold", "linear"], undefined, [0, 1]);
  add("analyze", "analysis.html", ["analyze", guide("ball.toml")], undefined, [0, 1]);
  const map = ["--map", "l=0.1..1,m=0.05..1", "--cells", "6"];
  add("map", "parameter_map.html", ["analyze", model("cart_pole.toml"), ...map], undefined, [0, 1]);
  add("parameters", "parameters.html", ["analyze", model("cart_pole.toml"), "--parameters", "l"], undefined, [0, 1], false);
  const rest = ["--from-rest", "--bounds", "der(theta,2)=-20..20", "--map", "der(X,2)=1..5,theta=0.1..0.5", "--cells", "6"];
  add("rest", "from_rest_map.html", ["analyze", model("plate_published.toml"), ...rest], undefined, [0, 1]);
  const pose = { x_plate: ["x", 1e3], y_plate: ["y", 1e3], phi_plate: ["φ", 180 / Math.PI], plate_theta: ["plate θ", 180 / Math.PI] };
  add("plate", "plate.html", ["plate", "1", "--seconds", "2", "--gif"], { file: file("plate", "trajectory.csv"), columns: pose }, [0, 1]);
  const robot = model("kr125.toml");
  add("identify", "identification.html", ["stiffness", "identify", measurements(file("", "measurements.csv")), robot, "--keep-outliers"], undefined, [0, 1]);
  add("compensate", "compensation.html", ["stiffness", "compensate", readings(file("", "log.csv")), robot], undefined, [0, 1]);
  add("poses", "poses.html", ["stiffness", "poses", measurements(file("", "candidates.csv")), robot], undefined, [0, 1], false);
  return pages;
}

const POSE = [0.2, -0.4, 0.6, 0.3, 0.8, 0.1];
const joints = (k) => POSE.map((angle, i) => angle + 0.5 * Math.sin(k * (i + 1.3)));
const wrench = (k) => [0.7, 1.9, 2.3, 3.1, 4.7, 5.3].map((f, i) => (i < 3 ? 800 : 50) * Math.sin(1 + f * k));
const write = (name, header, rows) => {
  fs.writeFileSync(name, [header, ...rows.map((row) => row.join(","))].join("\n") + "\n");
  return name;
};

/** Loads and displacements of a tool point that yields alike in all poses. */
function measurements(name) {
  const row = (k) => [...joints(k), ...wrench(k), ...wrench(k).map((load, i) => (i < 3 ? 1e-6 : 1e-5) * load)];
  const rows = Array.from({ length: 60 }, (_, k) => row(k));
  return write(name, "q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz,dx,dy,dz,rx,ry,rz", rows);
}

/** A slow motion with a force that swings. */
function readings(name) {
  const row = (k) => [0.004 * k, ...POSE.map((angle) => angle + 0.2 * Math.sin(0.002 * k)), ...wrench(0.01 * k).map((load) => 0.1 * load)];
  const rows = Array.from({ length: 500 }, (_, k) => row(k));
  return write(name, "t,q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz", rows);
}
