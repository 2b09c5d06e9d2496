#!/usr/bin/env python3
"""Closed-loop costs of the problem files in models/, by CasADi and IPOPT in place of the library.

    python benches/peers/control_references.py [PROBLEM.toml ...]

reads the same TOML files, writes the same discretized problem (control_problem.py), solves it to convergence at every sample
and applies the first input to the plant. A smooth plant is integrated by the same Runge-Kutta method with `plant_substeps`,
one with sign() by small steps with sliding modes (one switching function at most). Without names it takes all files that
tests quote. Needs casadi and numpy.
"""
import argparse
import pathlib
import time

from control_problem import Problem

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"
QUOTED = [
    "cart_pole_swing_up", "double_integrator_rest", "van_der_pol_rest", "cstr_set_point", "klatt_engell_set_point",
    "fed_batch_production", "oscillating_masses_rest", "chain_of_masses_rest", "quadrotor_flight",
    "cart_pole_friction_swing_up", "spring_mass_friction_target",
]


def closed_loop(problem, samples=None):
    """Runs the closed loop; its cost, the first solution, the last state, and the number of samples without convergence."""
    x, z, cost, opening, failures = problem.x0.copy(), problem.guess(), 0.0, None, 0
    for k in range(samples or problem.samples):
        widths = problem.widths if k == 0 else problem.widths[-1:]
        solved = problem.solve(z, x, k * problem.dt, widths)
        failures += not solved.success
        opening = opening or solved
        u = solved.z[:problem.model.m]
        cost += problem.dt * float(problem.stage(x, u, k * problem.dt))
        x = problem.advance_plant(x, u, k * problem.dt, problem.dt)
        z = problem.shifted(solved.z)
    return cost, opening, x, failures


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problems", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    for path in arguments.problems or [MODELS / f"{name}.toml" for name in QUOTED]:
        problem = Problem(path)
        if problem.plant.surfaces > 1:
            raise SystemExit(f"{path.stem}: more than one switching function: not covered here")
        began = time.time()
        cost, opening, x, failures = closed_loop(problem)
        final = ", ".join(f"{s} = {v:.6g}" for s, v in zip(problem.model.states, x))
        print(f"{path.stem}: closed loop {cost:.6f}, first optimum with penalties {opening.penalized:.6f}, {failures} of "
              f"{problem.samples} samples not converged, {(time.time() - began) / problem.samples * 1e3:.1f} ms a sample\n"
              f"    {final}", flush=True)
