//! The registry of movement policies: names and codes mean one policy each, for good, and the book
//! lists them all.

use chain::policy::{NAMES, Policy, PolicyConfig, REGISTRY};
use units::PolicyCode;

/// Drones in the field have these codes in their settings: a row may be added, none may change.
const GIVEN_OUT: [(u8, &str); 6] =
    [(1, "t0"), (2, "t5"), (3, "k"), (4, "authors"), (5, "k-tuned"), (6, "chain")];

#[test]
fn a_code_keeps_its_policy() {
    for (code, name) in GIVEN_OUT {
        let code = PolicyCode::new(code).unwrap();
        let named = Policy::with_code(code).map(|policy| policy.name);
        assert!(named.is_none_or(|named| named == name), "code {code:?} now means {named:?}");
    }
    for policy in &REGISTRY {
        let row = (policy.code.get(), policy.name);
        assert!(GIVEN_OUT.contains(&row), "{row:?} is new: add it to this test");
    }
}

#[test]
fn each_name_and_each_code_means_one_policy() {
    for policy in &REGISTRY {
        assert_eq!(Policy::named(policy.name), Some(policy));
        assert_eq!(Policy::with_code(policy.code), Some(policy));
    }
    assert_eq!(NAMES, REGISTRY.map(|policy| policy.name));
    assert_eq!(Policy::named("T0"), None);
    assert_eq!(Policy::with_code(PolicyCode::new(255).unwrap()), None);
}

#[test]
fn the_policy_named_default_is_the_default() {
    let default = Policy::named("k-tuned").map(|policy| policy.config);
    assert_eq!(default, Some(PolicyConfig::K_TUNED));
}

#[test]
fn the_book_has_the_registry() {
    let book = include_str!("../../../../docs/src/policies.md");
    let table = book.split("| name | code | policy |\n|---|---|---|\n").nth(1).unwrap();
    let rows: Vec<&str> = table.lines().take_while(|line| line.starts_with('|')).collect();
    let registry = REGISTRY.map(|policy| {
        format!("| `{}` | {} | {} |", policy.name, policy.code.get(), policy.summary)
    });
    assert_eq!(rows, registry);
}

#[test]
fn the_book_lists_the_names_where_one_can_be_given() {
    let quoted = NAMES.map(|name| format!("`\"{name}\"`")).join(", ");
    assert!(include_str!("../../../../docs/src/scenarios.md").contains(&quoted), "{quoted}");
    let named = NAMES.map(|name| format!("`{name}`")).join(", ");
    assert!(include_str!("../../../../docs/src/replay.md").contains(&named), "{named}");
}
