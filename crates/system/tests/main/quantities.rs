//! Units and labels: what a model states of its quantities is read, written, and stands at axes.

use bracketry_system::{Quantities, System, TimeUnit};

const CART: &str = "states = ['x', 'v']\ninputs = ['F']\n[parameters]\nm = { value = 2, unit = 'kg' }\n[dynamics]\nx = 'v'\nv = 'F/m'\n\
                    [outputs]\nmeasured = 'x'\n";

fn error(more: &str) -> String {
    System::parse("cart.toml", &format!("{CART}{more}")).err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn what_is_stated_is_read_and_written() {
    let text = format!(
        "time_unit = 'min'\n{CART}[units]\nx = 'm'\nF = 'N'\nmeasured = 'mm'\n[labels]\nF = 'pull of the rope'\n"
    );
    let read = System::parse("cart.toml", &text).unwrap();
    let again = System::parse("again.toml", &read.to_toml().unwrap()).unwrap();
    for system in [&read, &again] {
        let q = &system.quantities;
        assert_eq!(q.time_unit, TimeUnit::Minute);
        assert_eq!(
            [q.unit("x"), q.unit("v"), q.unit("F"), q.unit("measured")],
            [Some("m"), None, Some("N"), Some("mm")]
        );
        assert_eq!([q.title("x"), q.title("v"), q.title("F")], ["x [m]", "v", "pull of the rope F [N]"]);
        assert_eq!(q.time_title("duration"), "duration [min]");
        assert_eq!(system.all_quantities().title("m"), "m [kg]");
    }
    let plain = System::parse("cart.toml", CART).unwrap();
    assert_eq!(plain.quantities, Quantities::default());
    assert!(!plain.to_toml().unwrap().contains("units"));
    assert!(!plain.to_toml().unwrap().contains("time_unit"));
}

#[test]
fn derivatives_have_the_unit_over_a_power_of_the_time() {
    let unit = |of: &str, time: TimeUnit, order: u32| {
        let mut q = Quantities::default();
        q.time_unit = time;
        q.set_unit("x", of);
        q.unit_of_derivative("x", order).unwrap()
    };
    for (of, order, expected) in [
        ("m", 0, "m"),
        ("m", 1, "m/s"),
        ("m", 2, "m/s²"),
        ("m/s", 1, "m/s²"),
        ("m/s²", 1, "m/s³"),
        ("m/s^2", 2, "m/s⁴"),
        ("m²", 1, "m²/s"),
        ("1", 1, "1/s"),
        ("m", 12, "m/s^12"),
    ] {
        assert_eq!(unit(of, TimeUnit::Second, order), expected, "{of}, {order}");
    }
    assert_eq!(unit("mol/L", TimeUnit::Hour, 1), "mol/L/h");
    assert_eq!(unit("x0", TimeUnit::Dimensionless, 3), "x0");
    assert_eq!(Quantities::default().unit_of_derivative("x", 1), None);
}

#[test]
fn integrators_in_front_of_inputs_have_the_units_of_the_derivatives() {
    let text = "states = ['v']\ninputs = ['X']\n[dynamics]\nv = '-der(X, 2)'\n[units]\nv = 'm/s'\nX = 'm'\n";
    let system = System::parse("table.toml", text).unwrap();
    let affine = system.affinize().unwrap().system;
    let titles =
        affine.state_names().into_iter().chain(affine.input_names()).map(|name| affine.quantities.title(&name));
    assert_eq!(titles.collect::<Vec<_>>(), ["v [m/s]", "X [m]", "Xd [m/s]", "Xdd [m/s²]"]);
}

#[test]
fn units_of_time_have_symbols_and_seconds() {
    for symbol in ["ns", "us", "ms", "s", "min", "h", "d", "a", "1"] {
        assert_eq!(TimeUnit::parse(symbol).unwrap().symbol(), symbol);
    }
    assert_eq!(TimeUnit::parse("µs").unwrap(), TimeUnit::Microsecond);
    assert_eq!(TimeUnit::Day.seconds(), Some(86_400.0));
    assert_eq!(TimeUnit::Dimensionless.seconds(), None);
    assert_eq!([TimeUnit::Hour.text(3), TimeUnit::Dimensionless.text(3)], ["3 h", "3"]);
}

#[test]
fn calls_state_them_as_files_do() {
    let b = System::builder("cart");
    let (x, u) = (b.state("x"), b.input("u"));
    b.dynamics(x, u);
    b.describe(x, "m", "position of the cart");
    b.time_unit(TimeUnit::Hour);
    let system = b.build().unwrap();
    assert_eq!(system.quantities.title("x"), "position of the cart x [m]");
    assert_eq!(system.quantities.time_unit, TimeUnit::Hour);
}

#[test]
fn what_cannot_have_a_unit_is_refused_with_the_remedy() {
    for (more, message, remedy) in [
        ("[units]\nw = 'm/s'\n", "`w` is not a state, input, or output", "the model has x, v, F, measured"),
        ("[units]\nmeasure = 'm/s'\n", "`measure` is not a state, input, or output", "did you mean `measured`?"),
        (
            "[units]\nm = 'kg'\n",
            "the unit of the parameter `m` belongs in [parameters]",
            "write m = { value = 1.0, unit =",
        ),
        ("[units]\nx = 1\n", "the entry of `x` in [units] is not text", "write x = \"…\" in quotes"),
        ("[labels]\nx = ['a']\n", "the entry of `x` in [labels] is not text", "write x = \"…\" in quotes"),
    ] {
        let said = error(more);
        assert!(said.contains(message) && said.contains(remedy) && said.contains("cart.toml:"), "{said}");
    }
    let said = System::parse("cart.toml", &format!("time_unit = 'hours'\n{CART}")).err().unwrap().to_string();
    assert!(
        said.contains("`hours` is not a unit of time") && said.contains("\"h\"") && said.contains("cart.toml:1"),
        "{said}"
    );
}
