//! The domain of DDS that a node joins.

use input::InputError;

/// The largest number of a domain whose UDP ports exist: 7400 + 250 · 232 and those after it are the last
/// below 65,536 (DDSI-RTPS 2.5, 9.6.2).
pub const LARGEST_DOMAIN: u16 = 232;

/// The number of a domain, 0 to [`LARGEST_DOMAIN`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain(u16);

impl Domain {
    /// The domain that the value of an option `--ros2` names; where it names none, that of the variable
    /// `ROS_DOMAIN_ID` of the environment, or 0.
    ///
    /// # Errors
    /// [`InputError`] if it is no number of a domain.
    pub fn of_option(value: Option<&str>) -> Result<Self, InputError> {
        let from_environment = || std::env::var("ROS_DOMAIN_ID").ok();
        match value {
            None => Self::read(&from_environment().unwrap_or_else(|| "0".into()), "ROS_DOMAIN_ID="),
            Some(value) => Self::read(value, "--ros2="),
        }
    }

    fn read(text: &str, source: &str) -> Result<Self, InputError> {
        let number = text.parse().ok().filter(|number| *number <= LARGEST_DOMAIN);
        number.map(Self).ok_or_else(|| {
            let wrong = format!("{source}{text} is no domain of ROS 2");
            InputError::new(wrong, format!("give a whole number from 0 to {LARGEST_DOMAIN}"))
        })
    }

    /// The number.
    #[must_use]
    pub const fn number(self) -> u16 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_domain_is_a_number_whose_ports_exist() {
        assert_eq!(Domain::of_option(Some("232")).unwrap().number(), 232);
        for wrong in ["233", "-1", "", "1.5", "zero"] {
            let error = Domain::of_option(Some(wrong)).unwrap_err().to_string();
            assert!(error.contains(&format!("--ros2={wrong} is no domain")), "{error}");
        }
    }
}
