//! The story's figures for other programs.

use bracketry::plate::control::{Arrival, target_of};
use serde_json::{Value, json};

use super::story::Story;
use super::truth::{is_in_plant, value_in_plant};

impl Story {
    /// The figures of all chapters as one JSON object. Lengths in m, angles in deg, times in s unless a name says otherwise.
    pub fn summary(&self) -> Value {
        let own = &self.on_equations;
        let report = &own.together.run.report;
        let arrival = &own.arrival;
        let [linearize, qp, rest] = own.step_split();
        let plate = &own.together.recording.trajectory.final_state()[6..];
        let [x, y, phi] = own.two_step_errors();
        let object = &self.settings.plant.object;
        let target = target_of(&own.problem);
        json!({
            "seed": self.settings.seed,
            "target": {"x_m": target[0], "y_m": target[1], "phi_deg": target[2].to_degrees(), "within": {"m": Arrival::TOLERANCE_M,
                "deg": Arrival::TOLERANCE_DEG, "deg_s": Arrival::TOLERANCE_DEG}},
            "target_error": {"x_m": arrival.x_m, "y_m": arrival.y_m, "phi_deg": arrival.phi_deg},
            "spin_deg_s": arrival.spin_deg_s,
            "time_s": arrival.settled_s,
            "two_step_time_s": own.two_step_time(),
            "step_ms": report.solve_ms,
            "real_time_factor": own.real_time_factor(),
            "step_split_ms": {"linearise": linearize, "qp": qp, "rest": rest},
            "sampling_period_ms": report.period_ms,
            "shortest_s": own.shortest_s(),
            "move_s": own.problem.ocp.steps as f64 * own.problem.ocp.dt,
            "simulated_s": own.together.recording.trajectory.end(),
            "status": report.status,
            "plate_at_end": {"X_m": plate[0], "Xd_m_s": plate[1], "theta_deg": plate[2].to_degrees(),
                             "thetad_deg_s": plate[3].to_degrees()},
            "bound_excess": {"stroke_m": arrival.stroke_excess_m, "tilt_deg": arrival.tilt_excess_deg},
            "plan": report.plan,
            "effort": {"programs": {"on_equations": own.programs, "published_model": self.as_published.programs,
                "extended_model": self.extended.as_ref().map(|m| m.programs)}},
            "from_rest": {"thresholds": self.from_rest.thresholds, "complete": self.from_rest.is_complete()},
            "two_step": {"x_m": x, "y_m": y, "phi_deg": phi, "spin_deg_s": own.two.remaining_spin.to_degrees(),
                         "stages": own.two.stages.iter().map(|s| json!({"name": s.name, "from_s": s.from,
                             "to_s": s.to, "met": s.met})).collect::<Vec<_>>()},
            "true_plant": {"published_model": self.as_published, "extended_model": self.extended},
            "succeeded": self.succeeded(),
            "causes": self.diagnosis.report.causes.iter().map(|c| json!({"name": c.name, "equation": c.equation,
                "parameters": c.parameters.iter().map(|(name, v)| json!({"name": name, "value": v.value,
                    "interval": v.interval, "in_plant": value_in_plant(name, object)})).collect::<Vec<_>>(),
                "in_plant": is_in_plant(c, object)})).collect::<Vec<_>>(),
            "diagnosis": self.diagnosis,
            "gain": self.gain().into_iter().map(|(horizon_s, times_smaller)| json!({"horizon_s": horizon_s,
                "times_smaller": times_smaller})).collect::<Vec<_>>(),
            "seconds": self.seconds,
        })
    }
}
