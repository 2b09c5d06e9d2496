//! The stiffness of robots in words.

use std::fmt::{self, Write};

use bracketry_stiffness::{
    Advice, CartesianEstimate, CartesianEstimator, ChosenPoses, Comparison, CompensatedLog, Fault, Found,
    Identification, LoopGain, LostMotionReport, Method, MethodReport, Payload, SpringResidual, WRENCH_COLUMNS,
    Weighing, Withheld,
};
use bracketry_system::counted;
use nalgebra::Matrix6;

/// Writing to a string does not fail.
fn printed(write: impl FnOnce(&mut String) -> fmt::Result) -> String {
    let mut out = String::new();
    let _ = write(&mut out);
    out
}

pub(super) fn listed<T: ToString>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// What a comparison says of a method.
pub fn advice(advice: &Advice) -> String {
    match advice {
        Advice::Trust { method, held_out, explains: false } => format!(
            "no method explains the measurements; {method} is the best: it predicts held-out displacements to {held_out:.2} σ and, of the \
             methods that do so, has the fewest parameters"
        ),
        Advice::Trust { method, held_out, explains: true } => format!(
            "trust {method}: this method predicts held-out displacements to {held_out:.2} σ and, of the methods that do so, has the fewest parameters"
        ),
        Advice::DoesNotApply { method, why } => format!("{method}: not applicable: {why}"),
        Advice::Attenuated { estimator, attenuation } => {
            let (noise, too_small, ending) = match estimator {
                CartesianEstimator::WrenchOnDisplacement => ("ΔX", "K", ", however many measurements there are"),
                _ => ("W", "C", ""),
            };
            let (worst, percent) = (attenuation.worst, 100.0 * attenuation.error);
            format!(
                "{estimator}: the noise of {noise} makes {too_small} too small, by a factor of {worst:.3} in the \
                 worst direction and {percent:.1} % overall{ending}"
            )
        }
        Advice::NotPositiveDefinite(estimator) => {
            format!("{estimator}: not positive definite: the structure would move against some loads")
        }
        Advice::NotSymmetric(estimator) => {
            format!("{estimator}: not symmetric beyond noise: a closed cycle of loads would gain energy")
        }
        Advice::NotIdentified(why) => format!("{}: {why}", Method::JointSprings),
        Advice::Misfit { residual } => format!(
            "{}: residuals of {residual:.1} σ: the model misses an effect, or the noise is larger than stated",
            Method::JointSprings
        ),
        Advice::NoiseOverstated { residual } => format!(
            "the residuals are {residual:.2} times the stated noise: the measurements are better than stated, and the \
             intervals are wider than necessary"
        ),
    }
}

/// Why springs are not written into the robot file.
pub fn withheld(why: &Withheld) -> String {
    match why {
        Withheld::OtherMethod { method, residual } => format!(
            "{method} predicts better than the joint springs, whose residual is {residual:.1} σ: another part is \
             compliant too"
        ),
        Withheld::LostMotion { share } => format!(
            "lost motion in joints explains {:.0} % of the residual of the joint springs: include it in the fit, as described below",
            100.0 * share
        ),
        Withheld::Misfit { residual } => format!(
            "the residual of the joint springs is {residual:.1} σ: give a joint `gap` and `engaged`, or `cubic`, as start values, or \
             raise [noise] if the measurements are that noisy"
        ),
    }
}

/// What was wrong with the input of a compensation.
pub fn fault(fault: Fault) -> String {
    match fault {
        Fault::Count => "the number of coordinates is not that of the joints".to_owned(),
        Fault::Reading(i) => format!("no reading of {}", WRENCH_COLUMNS[i]),
        Fault::Range => {
            "the reading exceeds the sensor's range: overload, or wrong units (mN for N, N·mm for N·m)".to_owned()
        }
        Fault::Measured(i) => format!("no measured q{}", i + 1),
        Fault::Reference(i) => format!("no reference of joint {}", i + 1),
        Fault::Unbounded => "coordinates too large for a pose".to_owned(),
    }
}

/// An identification.
pub fn identification(found: &Identification) -> String {
    printed(|out| {
        writeln!(out, "{}: {} measurements", found.robot, found.measurements)?;
        if !found.outliers.is_empty() {
            writeln!(out, "excluded as outliers: lines {}", listed(&found.outliers))?;
        }
        if let Some(why) = &found.outliers_kept {
            writeln!(out, "no outliers excluded: {why}")?;
        }
        write_methods(out, found)?;
        write_parameters(out, found)?;
        if let Some(rest) = &found.residual {
            write!(out, "\n{}", residual(rest))?;
        }
        found.cartesian.as_ref().map_or(Ok(()), |estimate| write_cartesian(out, estimate))
    })
}

fn write_methods(out: &mut String, found: &Identification) -> fmt::Result {
    writeln!(out, "\n{:24} {:>23} {:>10} {:>8}", "method", "error of prediction [σ]", "condition", "χ²/dof")?;
    for (method, figures) in &found.methods {
        let (held_out, condition, chi_square) = match figures {
            Ok(f) => (format!("{:.3}", f.held_out), format!("{:.1}", f.condition), format!("{:.2}", f.chi_square)),
            Err(_) => ("–".to_owned(), "–".to_owned(), "–".to_owned()),
        };
        writeln!(out, "{method:24} {held_out:>23} {condition:>10} {chi_square:>8}")?;
    }
    writeln!(out)?;
    found.advice.iter().try_for_each(|item| writeln!(out, "{}", advice(item)))?;
    // Methods that do not apply for the same reason share a line.
    let failed =
        found.methods.iter().filter_map(|(method, figures)| Some((method, figures.as_ref().err()?.to_string())));
    let mut alike: Vec<(String, Vec<String>)> = Vec::new();
    for (method, why) in failed {
        match alike.iter_mut().find(|(known, _)| *known == why) {
            Some((_, methods)) => methods.push(method.to_string()),
            None => alike.push((why, vec![method.to_string()])),
        }
    }
    alike.iter().try_for_each(|(why, methods)| writeln!(out, "{}: not applicable: {why}", methods.join("; ")))
}

fn write_parameters(out: &mut String, found: &Identification) -> fmt::Result {
    use bracketry_stiffness::Identified;
    if !found.parameters.is_empty() {
        writeln!(out, "\njoint springs (N·m/rad, N·m/rad³, rad, N·m), 95 % interval")?;
    }
    for p in &found.parameters {
        let (joint, name) = (p.joint, p.name);
        match &p.identified {
            Identified::Yes { value, low, high } => {
                writeln!(out, "joint {joint} {name:10} {value:.4e}  ({low:.4e} … {high:.4e})")?;
            }
            no @ Identified::No { .. } => {
                writeln!(out, "joint {joint} {name:10} not identified: {}", no.why().unwrap_or_default())?;
            }
        }
    }
    if let Some(why) = &found.withheld {
        writeln!(out, "these springs are not written, and their intervals are not valid: {}", withheld(why))
    } else if found.parameters.is_empty() {
        Ok(())
    } else {
        writeln!(out, "the intervals are valid if the model is")
    }
}

fn write_cartesian(out: &mut String, estimate: &CartesianEstimate) -> fmt::Result {
    writeln!(out, "\ncompliance at the tool point, base axes [µm, µrad per N, N·m], ± half of the 95 % interval")?;
    write_matrix(out, &estimate.compliance, |i, j| estimate.compliance_interval(i, j), 1e6)?;
    writeln!(out, "\nstiffness, its inverse [N, N·m per µm, µrad]")?;
    write_matrix(out, &estimate.stiffness, |i, j| estimate.stiffness_interval(i, j), 1e-6)
}

fn write_matrix(
    out: &mut String,
    values: &Matrix6<f64>,
    interval: impl Fn(usize, usize) -> (f64, f64),
    scale: f64,
) -> fmt::Result {
    (0..6).try_for_each(|i| {
        let cell = |j: usize| {
            let (low, high) = interval(i, j);
            format!("{:9.4} ± {:.4}", scale * values[(i, j)], 0.5 * scale * (high - low))
        };
        writeln!(out, "{}", (0..6).map(cell).collect::<Vec<_>>().join("  "))
    })
}

/// What the springs of the joints leave of measured translations.
pub fn residual(found: &SpringResidual) -> String {
    printed(|out| {
        let [measured, left, noise] = [found.measured_rms, found.residual_rms, found.noise_rms].map(|v| 1e6 * v);
        let springs = if found.linear { "the linear springs" } else { "the springs" };
        write!(out, "translations {measured:.1} µm rms; residual of {springs} {left:.1} µm, noise {noise:.1} µm: ")?;
        if found.share == 0.0 {
            return writeln!(out, "nothing remains to be explained");
        }
        let model = if found.linear { "a linear" } else { "such a" };
        let (share, line) = (100.0 * found.share, found.worst_line);
        writeln!(
            out,
            "{share:.1} % of the rms is not explained by {model} model of the joints; largest residual at line {line}"
        )?;
        for lost in &found.lost_motion {
            writeln!(
                out,
                "joint {}: lost motion explains {:.0} % of the residual; give it gap = {:.1e}, engaged = {:.0} in the robot file and identify again",
                lost.joint,
                100.0 * lost.share,
                lost.gap,
                lost.engaged
            )?;
        }
        match found.with_lost_motion_rms {
            Some(remain) => writeln!(out, "residual with lost motion {:.1} µm", 1e6 * remain),
            None if found.linear => writeln!(out, "no lost motion found"),
            None => Ok(()),
        }
    })
}

/// All methods on the same data.
pub fn comparison(compared: &Comparison) -> String {
    let yes = |b: bool| if b { "yes" } else { "no" };
    printed(|out| {
        writeln!(
            out,
            "{:24} {:>12} {:>10} {:>8} {:>10} {:>10}",
            "method", "held out [σ]", "condition", "χ²/dof", "symmetric", "pos. def."
        )?;
        for (method, report) in &compared.methods {
            let Ok(MethodReport { found, held_out, .. }) = report else {
                writeln!(out, "{method:24} {:>12}", "–")?;
                continue;
            };
            let (symmetric, definite) = match found {
                Found::Cartesian(estimate) => (yes(estimate.symmetric), yes(estimate.positive_definite)),
                Found::Springs(_) => ("yes", "yes"),
            };
            let (condition, chi_square) = (found.condition(), found.chi_square());
            writeln!(
                out,
                "{method:24} {held_out:12.3} {condition:10.1} {chi_square:8.2} {symmetric:>10} {definite:>10}"
            )?;
        }
        compared.advice.iter().try_for_each(|item| writeln!(out, "{}", advice(item)))?;
        write!(out, "{} measurements excluded as outliers", compared.outliers.len())
    })
}

/// What is left of measured displacements, and why.
pub fn lost_motion(report: &LostMotionReport) -> String {
    printed(|out| {
        writeln!(
            out,
            "measured minus modeled displacement {:.1} µm rms; with the best joint stiffnesses {:.1} µm: {:.0} % of the rms is not explained by a linear model",
            1e6 * report.residual,
            1e6 * report.linear,
            100.0 * report.unexplained()
        )?;
        for lost in &report.lost_motion {
            writeln!(
                out,
                "joint {}: lost motion of {:.3} mrad, flanks engaged from {:.0} N·m on, {} torque reversals; explains {:.0} % of the mean square",
                lost.joint,
                1e3 * lost.gap,
                lost.engaged,
                lost.reversals,
                100.0 * lost.share
            )?;
        }
        if report.lost_motion.is_empty() {
            writeln!(out, "no lost motion found")
        } else {
            writeln!(out, "residual with lost motion {:.1} µm", 1e6 * report.nonlinear)
        }
    })
}

/// What is assumed without springs.
pub(super) const NO_SPRINGS: &str = "the robot file has no springs: 1 MN·m/rad was taken for each joint";

/// Expected errors and the condition: what, of the chosen measurements, of all.
pub(super) fn expected_errors(found: &ChosenPoses) -> Vec<[String; 3]> {
    let percent = |value: &Option<f64>| {
        value.map_or_else(|| "not identified".to_owned(), |value| format!("{:.1} %", 100.0 * value))
    };
    let errors = found.parameters.iter().zip(&found.chosen.errors).zip(&found.all.errors);
    let mut rows: Vec<[String; 3]> = errors
        .map(|(((joint, name), chosen), all)| [format!("joint {joint} {name}"), percent(chosen), percent(all)])
        .collect();
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.1}"));
    rows.push(["condition".to_owned(), number(found.chosen.condition), number(found.all.condition)]);
    rows
}

/// A choice of measurements.
pub fn chosen_poses(found: &ChosenPoses) -> String {
    printed(|out| {
        writeln!(
            out,
            "{}: the {} most informative of {} measurements",
            found.robot,
            found.lines.len(),
            found.candidates
        )?;
        writeln!(out, "lines {}", listed(&found.lines))?;
        writeln!(out, "\n{:20} {:>16} {:>16}", "expected error", "of these", "of all")?;
        for [what, chosen, all] in expected_errors(found) {
            writeln!(out, "{what:20} {chosen:>16} {all:>16}")?;
        }
        if !found.springs_known {
            writeln!(out, "\n{NO_SPRINGS}")?;
        }
        Ok(())
    })
}

/// What a force sensor carries.
pub fn weighing(found: &Weighing) -> String {
    printed(|out| {
        let (estimate, payload) = (&found.estimate, &found.estimate.payload);
        writeln!(
            out,
            "{}: payload of the sensor, from {} readings, ± standard deviation",
            found.robot, found.readings
        )?;
        writeln!(out, "mass {:.4} ± {:.4} kg", payload.mass, estimate.mass_deviation)?;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let (center, deviation) = (1e3 * payload.center[i], 1e3 * estimate.center_deviation[i]);
            writeln!(out, "center {axis} {center:.2} ± {deviation:.2} mm, in the sensor's frame")?;
        }
        for (i, (value, deviation)) in payload.bias.iter().zip(&estimate.bias_deviation).enumerate() {
            let unit = if i < 3 { "N" } else { "N·m" };
            writeln!(out, "bias {} {value:.4} ± {deviation:.4} {unit}", WRENCH_COLUMNS[i])?;
        }
        let ([force, moment], line) = (estimate.residual, found.worst_line);
        writeln!(out, "residual per reading {force:.3} N, {moment:.4} N·m; largest at line {line}")?;
        write!(out, "\n{}", payload_table(payload))
    })
}

/// The table `[payload]` for a robot file.
pub fn payload_table(payload: &Payload) -> String {
    let list = |values: &[f64]| values.iter().map(|v| format!("{v:.5}")).collect::<Vec<_>>().join(", ");
    let (center, bias) = (list(payload.center.as_slice()), list(payload.bias.as_slice()));
    format!("[payload]\nmass = {:.5}\ncentre = [{center}]\nbias = [{bias}]\n", payload.mass)
}

/// A compensation along a log.
pub fn compensated_log(run: &CompensatedLog) -> String {
    let samples = |count: usize| counted(count, "sample", "samples");
    printed(|out| {
        let duration = run.samples as f64 * run.period;
        writeln!(out, "{}: {} of {} s, {duration:.2} s", run.robot, samples(run.samples), run.period)?;
        writeln!(out, "process force up to {:.1} N at the tool point, filtered", run.force_max)?;
        let [rms, most] = [run.displacement_rms, run.displacement_max].map(|v| 1e6 * v);
        writeln!(out, "predicted displacement of the tool point: {rms:.1} µm rms, {most:.1} µm at most")?;
        let corrections: Vec<String> = run.correction_max.iter().map(|c| format!("{:.3}", 1e3 * c)).collect();
        writeln!(out, "largest correction of each joint [mrad, mm]: {}", corrections.join(", "))?;
        if run.limited > 0 {
            let samples = samples(run.limited);
            writeln!(
                out,
                "limits reached at {samples}: raise correction_limit or rate_limit if such corrections are intended"
            )?;
        }
        for count in &run.faults {
            writeln!(out, "held at {}: {}", samples(count.samples), fault(count.fault))?;
        }
        run.loop_gain.as_ref().map_or(Ok(()), |gain| out.write_str(&loop_gain(gain)))
    })
}

/// Whether a compensation and a process drive each other up.
pub fn loop_gain(found: &LoopGain) -> String {
    let ([x, y, z], gains) = (found.process_stiffness, found.gains);
    let verdict = if found.holds() {
        "both below 1: stable with any lag"
    } else {
        "not below 1: compensation and process may become unstable; reduce the depth of cut or the feed, or raise stiffness_error"
    };
    format!(
        "with a process stiffness of {x}, {y}, and {z} N/m along x, y, and z: process stiffness × compliance {:.3}, loop through the compensation {:.3}\n{verdict}\n",
        gains.process, gains.compensation
    )
}
