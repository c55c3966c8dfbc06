//! Takes the token of the station from where the operator has put it.
//!
//! The token is the only thing that keeps other machines of a network from flying the drones, so one
//! that can be guessed is refused. The arguments of a process can be read by every user of the
//! machine; a file of the operator's own, the environment of the process, and the terminal cannot.

use std::fs;
use std::path::Path;

/// The variable of the environment that may have the token.
pub const VARIABLE: &str = "UCHAIN_TOKEN";
/// The least length. At one guess a second and address ([`token_guard`](crate::token_guard)), eight
/// digits are found in a year and a half on average.
pub const LEAST: usize = 8;
/// The number of random bytes of a token that the station makes.
const BYTES: usize = 16;

/// Why there is no usable token, and how to mend it, in one line.
pub type Unusable = String;

/// Checks a token that was given.
///
/// # Errors
/// If it is too short.
pub fn check(token: &str) -> Result<String, Unusable> {
    if token.chars().count() < LEAST {
        return Err(format!(
            "the token is shorter than {LEAST} characters and can be guessed; \
             give a longer one, or --new-token"
        ));
    }
    Ok(token.to_owned())
}

/// Reads a token from a file that only its owner may read; blanks round the token are left out.
///
/// # Errors
/// If the file cannot be read, others may read it, or its token is too short.
pub fn read(path: &Path) -> Result<String, Unusable> {
    let about = |why: &dyn std::fmt::Display, remedy: &str| {
        format!("{}: the token cannot be taken from here ({why}); {remedy}", path.display())
    };
    let unreadable = |error: std::io::Error| about(&error, "give a file with the token in it");
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(about(&"it is not a file", "give a file with the token in it"));
    }
    #[cfg(unix)]
    {
        let mode = std::os::unix::fs::MetadataExt::mode(&metadata) & 0o777;
        if mode & 0o077 != 0 {
            let why = format!("others than you may read or change it, its mode is {mode:03o}");
            return Err(about(&why, &format!("run: chmod 600 '{}'", path.display())));
        }
    }
    let text = input::file::read_text(path, input::file::LARGEST_TEXT).map_err(unreadable)?;
    check(text.trim()).map_err(|why| format!("{}: {why}", path.display()))
}

/// Makes a token of random bytes, as hexadecimal digits.
///
/// # Errors
/// If the machine gives no random numbers.
pub fn make() -> Result<String, Unusable> {
    let mut bytes = [0_u8; BYTES];
    getrandom::fill(&mut bytes).map_err(|error| {
        format!("this machine gives no random numbers ({error}); give a token of your own")
    })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_that_can_be_guessed_is_refused() {
        for short in ["", "1234", "1234567"] {
            let why = check(short).unwrap_err();
            assert!(why.contains("shorter than 8") && why.contains("; give"), "{why}");
            assert!(short.is_empty() || !why.contains(short), "the token is not repeated: {why}");
        }
        assert_eq!(check("12345678").as_deref(), Ok("12345678"));
    }

    #[test]
    fn tokens_that_are_made_differ_and_are_long() {
        let (one, two) = (make().unwrap(), make().unwrap());
        assert_ne!(one, two);
        assert_eq!(one.len(), 2 * BYTES);
        assert!(check(&one).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_others_may_read_is_refused() {
        use std::os::unix::fs::PermissionsExt;
        let file = std::env::temp_dir().join(format!("uchain-token-{}", std::process::id()));
        fs::write(&file, "  a long token \n").unwrap();
        let with_mode = |mode| {
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            read(&file)
        };
        assert_eq!(with_mode(0o600).as_deref(), Ok("a long token"));
        for loose in [0o640, 0o604, 0o644] {
            let why = with_mode(loose).unwrap_err();
            assert!(why.contains("chmod 600") && why.lines().count() == 1, "{why}");
        }
        fs::remove_file(&file).unwrap();
        assert!(read(&file).is_err() && read(Path::new("/")).is_err());
    }
}
