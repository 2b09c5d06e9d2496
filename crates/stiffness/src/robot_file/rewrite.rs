//! Robot files with other springs.

use super::joints::{joint_tables, spring};
use crate::compliance::{JointSpring, Springs};
use bracketry_files::{Document, FileError, Table};

/// The text of a robot file with other springs of its joints; comments and everything else stay, compliances of links too.
///
/// # Errors
/// [`FileError`] for a text that is no robot file, or another number of joints.
pub fn with_springs(file: &str, text: &str, springs: &Springs) -> Result<String, FileError> {
    let document = Document::new(file, text);
    let table = document.table()?;
    let joints = joint_tables(&document, &table)?;
    let remedy = "write one [[joint]] for each joint, its keys on lines below";
    // Beside a URDF description there may be none yet.
    let described = joints.is_empty() && table.contains_key("urdf");
    if joints.len() != springs.joints.len() && !described {
        let message = format!("{} [[joint]] entries for {} springs", joints.len(), springs.joints.len());
        return Err(document.missing(message, remedy));
    }
    // What replaces a range of the text.
    let mut changes: Vec<(std::ops::Range<usize>, String)> = Vec::new();
    if described {
        let entry = |spring: &JointSpring| {
            let keys: Vec<String> =
                spring.parameters().iter().map(|(key, v)| format!("{key} = {}\n", significant(*v))).collect();
            format!("\n[[joint]]\n{}", keys.concat())
        };
        let entries: Vec<String> = springs.joints.iter().map(entry).collect();
        changes.push((text.len()..text.len(), format!("\n{}", entries.concat())));
    }
    for (joint, spring) in joints.iter().zip(&springs.joints) {
        for (key, value) in spring.parameters() {
            if let Some(old) = joint.get(key) {
                changes.push((old.span(), significant(value)));
            } else {
                changes.push(added(text, joint, key, value));
            }
        }
    }
    changes.sort_by_key(|(range, _)| range.start);
    let (mut changed, mut at) = (String::with_capacity(text.len()), 0);
    for (range, new) in changes {
        changed.push_str(&text[at..range.start]);
        changed.push_str(&new);
        at = range.end;
    }
    changed.push_str(&text[at..]);
    let rewritten = Document::new(file, changed.as_str());
    let written = rewritten.table().and_then(|table| {
        joint_tables(&rewritten, &table)?.iter().map(|joint| spring(&rewritten, joint)).collect::<Result<Vec<_>, _>>()
    });
    let same = |(new, old): (&Option<JointSpring>, &JointSpring)| new.as_ref().is_some_and(|new| close(new, old));
    match written {
        Ok(written) if written.len() == springs.joints.len() && written.iter().zip(&springs.joints).all(same) => {
            Ok(changed)
        }
        _ => Err(document.missing("cannot replace the springs", remedy)),
    }
}

/// A key that a joint does not have yet: on a line below its others, or behind them where they stand on one line between braces.
fn added(text: &str, joint: &Table<'_>, key: &str, value: f64) -> (std::ops::Range<usize>, String) {
    let last = joint.values().map(|value| value.span().end).max().unwrap_or(text.len());
    let value = significant(value);
    // Behind a value in braces there is a comma or the brace; behind others the end of the line or a comment.
    if text[last..].trim_start().starts_with([',', '}']) {
        return (last..last, format!(", {key} = {value}"));
    }
    let end = text[last..].find('\n').map_or(text.len(), |i| last + i);
    (end..end, format!("\n{key} = {value}"))
}

/// A number with six significant digits.
fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Whether springs are the same to the digits that are written.
fn close(a: &JointSpring, b: &JointSpring) -> bool {
    let (a, b) = (a.parameters(), b.parameters());
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() <= 1e-5 * b.1.abs())
}
