//! Builds the firmware by calling `cargo fw` or `cargo fw-plus`.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::Result;

/// The board that the firmware is built for.
#[derive(Clone, Copy)]
pub(crate) enum Board {
    Crazyflie21,
    Crazyflie21Plus,
}

impl Board {
    pub(crate) const fn of(plus: bool) -> Self {
        if plus { Self::Crazyflie21Plus } else { Self::Crazyflie21 }
    }

    /// In `.cargo/config.toml`.
    const fn alias(self) -> &'static str {
        match self {
            Self::Crazyflie21 => "fw",
            Self::Crazyflie21Plus => "fw-plus",
        }
    }
}

/// Builds the firmware and returns where its ELF file is.
pub(crate) fn build(board: Board) -> Result<PathBuf> {
    let alias = board.alias();
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args([alias, "--message-format=json-render-diagnostics"])
        // Where the alias is.
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .stderr(Stdio::inherit())
        .output()
        .map_err(|why| format!("cargo {alias}: {why}"))?;
    if !output.status.success() {
        return Err(format!("cargo {alias} failed, see above; nothing was written"));
    }
    executable(&String::from_utf8_lossy(&output.stdout))
        .ok_or_else(|| format!("cargo {alias} built no executable"))
}

/// The executable that cargo's messages, one JSON object on a line, tell of last.
fn executable(messages: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|message| Some(PathBuf::from(message.get("executable")?.as_str()?)))
        .next_back()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_found_among_other_messages() {
        let messages = "{\"reason\":\"compiler-artifact\",\"executable\":null}\n\
            {\"reason\":\"compiler-artifact\",\"executable\":\"/t/uchain-firmware\"}\n\
            not json\n{\"reason\":\"build-finished\",\"success\":true}\n";
        assert_eq!(executable(messages), Some(PathBuf::from("/t/uchain-firmware")));
        assert_eq!(executable(""), None);
    }
}
