//! The table `[static]` of model files.

use bracketry_system::{FileError, System};

fn model(table: &str) -> Result<System, FileError> {
    let text = format!(
        "states = [\"vx\", \"vy\", \"z\"]\ninputs = [\"X\"]\nparameters = {{ r = 1.25 }}\n[dynamics]\n\
         vx = \"-unit(vx - der(X), vy)\"\nvy = \"-unit(vy, vx - der(X)) - sign(z)\"\nz = \"abs(vx)\"\n[static]\n{table}\n"
    );
    System::parse("test.toml", &text)
}

#[test]
fn a_key_names_a_sign_or_all_components_of_a_unit_vector() {
    for key in ["\"vx - der(X), vy\"", "\"vy, der(X) - vx\"", "z"] {
        let mut read = model(&format!("{key} = \"r\"")).unwrap();
        assert_eq!(read.static_levels.len(), 1);
        // Written and read again it is the same.
        let written = read.to_toml().unwrap();
        let again = System::parse("again.toml", &written).unwrap();
        assert_eq!(again.static_levels.len(), 1, "{written}");
        let (form, level) = (read.set_valued_form(), read.static_levels[0].clone());
        assert_eq!(read.switch_of(&form, &level), Some(usize::from(key != "z") * form.signs().len()), "{key}");
    }
}

#[test]
fn a_key_without_friction_and_a_level_below_one_are_told_with_their_place() {
    let at = |table: &str| {
        let e = model(table).unwrap_err();
        (e.line, e.message, e.remedy)
    };
    let (line, message, remedy) = at("vx = 1.2");
    assert_eq!((line, message.as_str()), (9, "no dry friction acts on `vx`"));
    assert_eq!(remedy, "write one of: z; vx - der(X), vy");
    // |vx| has a kink there, no friction.
    assert!(at("\"vx, vy\" = 1.2").1.contains("no dry friction"));
    assert!(at("z = 0.9").1.contains("below its sliding level"));
    assert!(at("z = \"vx\"").1.contains("not constant"));
    assert!(at("q = 1.1").1.contains("unknown name"));
}
