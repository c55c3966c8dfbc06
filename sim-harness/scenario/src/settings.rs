//! Changes single keys of a scenario before it is read: `radio.packet_loss=0.2`.
//!
//! A key is written with dots, and an entry of a list by its number from 0 on: `pilot.1.at_s`. The
//! changed text goes through the reader of every scenario, so that a key or a value is right or
//! wrong as it is in a file.

use std::fmt;

use input::InputError;
use toml::{Table, Value};

/// A key of a scenario with another value. It displays as `key=value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    key: String,
    value: Value,
}

impl Setting {
    /// Makes a setting of a key with dots.
    pub fn new(key: impl Into<String>, value: Value) -> Self {
        Self { key: key.into(), value }
    }

    /// Reads `KEY=VALUE`.
    ///
    /// # Errors
    /// [`InputError`] where it is not of that form.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let (key, value) = text.split_once('=').ok_or_else(|| formless(text))?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(formless(text));
        }
        Ok(Self::new(key, value_of(value).ok_or_else(|| formless(text))?))
    }

    /// The key, with dots.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value.
    #[must_use]
    pub const fn value(&self) -> &Value {
        &self.value
    }

    /// Puts the value into a scenario.
    pub(super) fn put(&self, scenario: &mut Table) -> Result<(), InputError> {
        let mut parts = self.key.split('.');
        let last = parts.next_back().unwrap_or_default();
        let mut place = Place::Table(scenario);
        for part in parts {
            place = place.within(part).ok_or_else(|| self.nowhere(part))?;
        }
        place.put(last, self.value.clone()).ok_or_else(|| self.nowhere(last))
    }

    fn nowhere(&self, part: &str) -> InputError {
        let wrong = format!("nothing of the scenario is called \"{part}\" there");
        let remedy =
            "give tables and keys with dots, and an entry of a list by its number from 0 on";
        InputError::new(wrong, remedy).at_key(&self.to_string())
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            Value::String(text) => write!(f, "{}={text}", self.key),
            value => write!(f, "{}={value}", self.key),
        }
    }
}

/// Removes from a file's scenario what cannot stand beside a setting: where a law of the path loss is
/// set, the keys of the paper's law, which it replaces. Such keys that are set themselves are refused.
pub(super) fn make_room(settings: &[Setting], scenario: &mut Table) {
    let is_law = |key: &str| key == "radio.model" || key.starts_with("radio.model.");
    if !settings.iter().any(|setting| is_law(setting.key())) {
        return;
    }
    if let Some(Value::Table(radio)) = scenario.get_mut("radio") {
        radio.remove("attenuation");
        radio.remove("walls");
    }
}

fn formless(text: &str) -> InputError {
    let remedy = "give a key and its value, such as radio.packet_loss=0.2 or policy.name=k-tuned";
    InputError::new("this is no KEY=VALUE", remedy).at_key(text)
}

/// A value as TOML writes it; what is no such value is a string, so that a shell's user need not quote
/// one. `None` for a broken list, table or string.
pub fn value_of(text: &str) -> Option<Value> {
    let read = toml::from_str::<Table>(&format!("value = {text}"));
    match read.ok().filter(|read| read.len() == 1) {
        Some(mut read) => read.remove("value"),
        None if text.starts_with(['[', '{', '"', '\'']) || text.contains(['\n', '\r']) => None,
        None => Some(Value::String(text.to_owned())),
    }
}

/// A place in a scenario under which there are others.
enum Place<'a> {
    Table(&'a mut Table),
    List(&'a mut Vec<Value>),
}

impl<'a> Place<'a> {
    /// The place of this name; a table that is not there is made. `None` where there is a value.
    fn within(self, part: &str) -> Option<Self> {
        let value = match self {
            Self::Table(table) => table.entry(part).or_insert_with(|| Value::Table(Table::new())),
            Self::List(list) => list.get_mut(part.parse::<usize>().ok()?)?,
        };
        match value {
            Value::Table(table) => Some(Place::Table(table)),
            Value::Array(list) => Some(Place::List(list)),
            _ => None,
        }
    }

    fn put(self, part: &str, value: Value) -> Option<()> {
        match self {
            Self::Table(table) => {
                table.insert(part.to_owned(), value);
            }
            Self::List(list) => *list.get_mut(part.parse::<usize>().ok()?)? = value,
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Changes, Scenario};

    fn with(settings: &[&str]) -> Result<Scenario, String> {
        let read = settings.iter().map(|text| Setting::parse(text)).collect::<Result<_, _>>();
        let settings = read.map_err(|error| error.to_string())?;
        let changes = Changes { settings, ..Changes::default() };
        Scenario::open_with("demo", &changes).map_err(|error| error.to_string())
    }

    #[test]
    fn a_key_takes_the_value() {
        let scenario = with(&[
            "radio.packet_loss=0.35",
            "policy.name=k-tuned",
            "radio.datarate=1M",
            "drones.relays=2",
            "pilot.1.at_s=100",
            "vehicle.sees_drones=false",
        ])
        .unwrap();
        assert_eq!(scenario.radio.reception.loss_rate, 0.35);
        assert_eq!(scenario.policy, "k-tuned");
        assert_eq!(scenario.radio.datarate, wire::radio::Datarate::Mbit1);
        assert_eq!(scenario.drones.relays, 2);
        assert_eq!(scenario.pilot[1].at_us, 100_000_000);
        assert!(!scenario.vehicle.sees_drones);
        assert_eq!(scenario.name, "demo");
    }

    #[test]
    fn what_is_wrong_names_the_key_and_what_was_meant() {
        for (settings, parts) in [
            (
                &["radio.packet_los=0.2"][..],
                &["radio.packet_los=0.2: ", "did you mean packet_loss?"][..],
            ),
            (&["raido.packet_loss=0.2"], &["raido.packet_loss=0.2: ", "did you mean radio?"]),
            (&["radio.packet_loss=2"], &["radio.packet_loss=2: ", "from 0 to 1"]),
            (&["policy.name=k-tund"], &["policy.name=k-tund: ", "did you mean k-tuned?"]),
            (&["pilot.9.at_s=3"], &["pilot.9.at_s=3: ", "\"9\""]),
            (&["title.short=3"], &["title.short=3: ", "\"title\""]),
            (&["radio.packet_loss"], &["radio.packet_loss: this is no KEY=VALUE"]),
            (&["drones.relays=[1"], &["drones.relays=[1: "]),
            (&["link=exact", "radio.fade_share=7"], &["radio.fade_share=7: "]),
            // Right, each by itself.
            (&["launch.limit_dbm=-75.5", "retreat.limit_dbm=-75"], &["limit_dbm"]),
        ] {
            let error = with(settings).unwrap_err();
            assert_eq!(error.lines().count(), 1, "{error}");
            for part in parts {
                assert!(error.contains(part), "no {part:?} in {error}");
            }
        }
    }

    #[test]
    fn a_law_that_is_set_replaces_the_paper_s_of_the_file() {
        let with = |name, settings: &[&str]| {
            let settings = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
            let changes = Changes { settings, ..Changes::default() };
            Scenario::open_with(name, &changes).map_err(|error| error.to_string())
        };
        for law in ["radio.model={ law = \"subt\" }", "radio.model.law=subt"] {
            assert!(with("s-turns-5", &[law]).is_ok());
            assert!(with("leaky-u", &[law]).is_ok());
            let error = with("s-turns-5", &["radio.walls=leaky", law]).unwrap_err();
            assert!(error.contains("belong to the paper's law"), "{error}");
        }
    }

    #[test]
    fn two_that_are_right_only_together_are_taken() {
        assert!(with(&["retreat.limit_dbm=-60"]).is_err());
        assert!(with(&["retreat.limit_dbm=-60", "launch.limit_dbm=-50"]).is_ok());
    }
}
