//! Shapes and what is computed of them.

use bracketry_plate::object::ShapeError;
use bracketry_plate::{PlateError, Shape, published};

/// An L: two legs of 0.3 m and 0.2 m, 0.1 m wide.
const L: [[f64; 2]; 6] = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.1, 0.1], [0.1, 0.2], [0.0, 0.2]];

fn shapes() -> Vec<Shape> {
    vec![
        Shape::REFERENCE_DISK,
        Shape::REFERENCE_ELLIPSE,
        Shape::Rectangle { a: 0.15, b: 0.04 },
        Shape::polygon(&[[0.0, 0.0], [0.3, 0.1], [0.05, 0.2]]).unwrap(),
        Shape::polygon(&L).unwrap(),
    ]
}

#[test]
fn points_carry_area_centroid_and_second_moments_exactly() {
    for shape in shapes() {
        let (sxx, syy, sxy) = shape.second_moments_at(0.0);
        for count in [4, 5, 6, 7, 12, 31, 48, 50, 100, 768] {
            let rule = shape.quadrature(count).unwrap();
            assert!(rule.weights.iter().all(|w| *w > 0.0));
            let sum = |f: &dyn Fn([f64; 2]) -> f64| -> f64 {
                rule.points.iter().zip(&rule.weights).map(|(p, w)| w * f(*p)).sum()
            };
            assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-13);
            assert!(sum(&|p| p[0]).abs() < 1e-15 && sum(&|p| p[1]).abs() < 1e-15);
            assert!((sum(&|p| p[0] * p[0]) - sxx).abs() < 1e-16, "{shape:?} {count}");
            assert!((sum(&|p| p[1] * p[1]) - syy).abs() < 1e-16, "{shape:?} {count}");
            assert!((sum(&|p| p[0] * p[1]) - sxy).abs() < 1e-16, "{shape:?} {count}");
            assert!(rule.points.iter().all(|p| shape.contains(*p)), "{shape:?} {count}");
        }
    }
}

#[test]
fn the_number_of_points_is_the_requested_one_or_near_it() {
    for (shape, most) in shapes().into_iter().zip([0, 0, 4, 2, 2]) {
        for count in [24, 37, 48, 96, 768] {
            let n = shape.quadrature(count).unwrap().points.len();
            assert!(n.abs_diff(count) <= most, "{shape:?}: {n} for {count}");
        }
    }
}

#[test]
fn the_friction_torque_of_a_spinning_disk_is_exact() {
    // ∫ r dA/A = 2R/3: the radii of the rings are Gauss points for the weight r.
    for count in [12, 48, 768] {
        let rule = Shape::REFERENCE_DISK.quadrature(count).unwrap();
        let mean: f64 = rule.points.iter().zip(&rule.weights).map(|(p, w)| w * p[0].hypot(p[1])).sum();
        assert!((mean - 0.08).abs() < 1e-15, "{mean}");
    }
}

#[test]
fn moments_of_a_polygon_are_those_of_its_parts() {
    // The L is two rectangles; parallel axes.
    let parts = [([0.15, 0.05], 0.15, 0.05), ([0.05, 0.15], 0.05, 0.05)];
    let area: f64 = parts.iter().map(|p| 4.0 * p.1 * p.2).sum();
    let center = [0, 1].map(|k| parts.iter().map(|p| 4.0 * p.1 * p.2 * p.0[k]).sum::<f64>() / area);
    let moment = |i: usize, j: usize| -> f64 {
        let part = |p: &([f64; 2], f64, f64)| {
            let own = if i == j { [p.1, p.2][i].powi(2) / 3.0 } else { 0.0 };
            4.0 * p.1 * p.2 * (own + (p.0[i] - center[i]) * (p.0[j] - center[j]))
        };
        parts.iter().map(part).sum::<f64>() / area
    };
    let shape = Shape::polygon(&L).unwrap();
    assert!((shape.area() - area).abs() < 1e-15);
    let (sxx, syy, sxy) = shape.second_moments_at(0.0);
    assert!((sxx - moment(0, 0)).abs() < 1e-16 && (syy - moment(1, 1)).abs() < 1e-16);
    assert!((sxy - moment(0, 1)).abs() < 1e-16);
    // In principal axes the mixed moment vanishes.
    assert!(shape.second_moments_at(-shape.principal_angle()).2.abs() < 1e-16);
    assert!(shape.principal_angle() < -0.1);
}

#[test]
fn order_and_place_of_the_vertices_do_not_matter() {
    let shape = Shape::polygon(&L).unwrap();
    let mut backwards = L.map(|[x, y]| [x + 3.0, y - 7.0]);
    backwards.reverse();
    let other = Shape::polygon(&backwards).unwrap();
    assert!((shape.second_moments().0 - other.second_moments().0).abs() < 1e-14);
    assert!((shape.area() - other.area()).abs() < 1e-14);
    let Shape::Polygon { vertices } = other else { unreachable!() };
    assert!(vertices.iter().any(|p| (p[0] - (0.0 - 0.125)).abs() < 1e-14 && (p[1] - (0.0 - 0.075)).abs() < 1e-14));
}

#[test]
fn the_rim_bounds_the_shape() {
    for shape in shapes() {
        for point in shape.rim(40) {
            assert!((shape.rim_share(point) - 1.0).abs() < 1e-12 || matches!(shape, Shape::Polygon { .. }));
            let convex = shape != Shape::polygon(&L).unwrap();
            assert!(
                !convex || shape.contains(point.map(|p| 0.999_999 * p)) && !shape.contains(point.map(|p| 1.01 * p))
            );
            // The farthest point along a direction is at least as far as any other.
            let far = shape.support(point);
            assert!(far[0] * point[0] + far[1] * point[1] >= point[0] * point[0] + point[1] * point[1] - 1e-15);
        }
    }
    // The L is not convex: the notch lies within the hull, but not in the shape.
    let shape = Shape::polygon(&L).unwrap();
    let notch = [0.15 - 0.125, 0.13 - 0.075];
    assert!(!shape.contains(notch) && shape.rim_share(notch) < 1.0);
    assert!((shape.rim_share([0.3 - 0.125, 0.05 - 0.075]) - 1.0).abs() < 1e-12);
}

#[test]
fn shapes_survive_being_written_and_read() {
    let read: Shape = toml::from_str("[Polygon]\nvertices = [[0, 0], [1, 0], [0, 1]]").unwrap();
    assert_eq!(read, Shape::polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap());
    let crossing = toml::from_str::<Shape>("[Polygon]\nvertices = [[0, 0], [1, 1], [1, 0], [0, 1.5]]");
    assert!(crossing.unwrap_err().to_string().contains("must not cross itself"));
    assert_eq!(toml::from_str::<Shape>("[Rectangle]\na = 1.0\nb = 2.0").unwrap(), Shape::Rectangle { a: 1.0, b: 2.0 });
}

#[test]
fn shapes_without_meaning_are_refused_with_the_reason() {
    let refused = |vertices: &[[f64; 2]]| Shape::polygon(vertices).unwrap_err();
    assert_eq!(refused(&L[..2]), ShapeError::TooFewVertices { count: 2 });
    assert_eq!(refused(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]), ShapeError::NotFinite { index: 1 });
    assert_eq!(
        refused(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]),
        ShapeError::Coincident { index: 3, next: 0 }
    );
    assert!(matches!(refused(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), ShapeError::NoArea { .. }));
    // A bow tie of unequal loops, a spike, a corner that touches a side.
    let bow = refused(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
    assert_eq!(bow, ShapeError::SelfIntersecting { first: 0, second: 2 });
    let spike = refused(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert!(matches!(spike, ShapeError::SelfIntersecting { .. }));
    let touching = refused(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]]);
    assert!(matches!(touching, ShapeError::SelfIntersecting { .. }));
    let bad = Shape::Rectangle { a: 0.1, b: -1.0 }.quadrature(48);
    assert_eq!(bad.unwrap_err(), PlateError::BadNumber { name: "b", value: -1.0 });
    assert_eq!(Shape::REFERENCE_DISK.quadrature(3).unwrap_err(), PlateError::TooFewPoints { count: 3, least: 4 });
}

#[test]
fn the_published_model_sees_of_a_shape_only_its_second_moments() {
    let semi = |shape: Shape| {
        let system = published(&shape, 0.3).unwrap();
        ["a", "b"].map(|name| {
            let parameter = system.parameters.iter().find(|p| system.pool.name(p.symbol) == name).unwrap();
            parameter.value.to_f64().value()
        })
    };
    let rectangle = semi(Shape::Rectangle { a: 0.15, b: 0.1 });
    let square = Shape::polygon(&[[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]]).unwrap();
    assert_eq!(square.principal_angle(), 0.0);
    for (a, half) in rectangle.into_iter().chain(semi(square)).zip([0.15, 0.1, 0.1, 0.1]) {
        assert!((a - 2.0 * half / 3f64.sqrt()).abs() < 1e-15);
    }
    let turned = published(&Shape::polygon(&L).unwrap(), 0.3).unwrap_err();
    assert!(matches!(turned, PlateError::TurnedAxes { angle } if angle < -0.1));
}
