//! Carries out the commands, which begin with `*`.

mod instruments;
mod order;
mod places;

use std::rc::Rc;

use super::characters::{Characters, Class, Cursor};
use super::date::{self, DateError};
use super::settings::Case;
use super::{Block, MOST_BLOCKS, Reader};
use crate::error::Refusal;

/// Commands after which `*export` may still come, beside those that say nothing of stations.
const END_OF_EXPORTS: [&str; 5] = ["entrance", "equate", "fix", "include", "end"];

/// The version of Survex whose grammar is read, for `*require`.
const VERSION: [u32; 3] = [1, 4, 22];

impl Reader<'_> {
    /// Carries out the command at the cursor; `blocks` were open when its file began.
    pub(super) fn command(
        &mut self,
        cursor: &mut Cursor<'_>,
        blocks: usize,
    ) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let before = *cursor;
        let word = cursor.keyword(&characters);
        if END_OF_EXPORTS.contains(&&*word) {
            self.may_export = false;
        }
        match &*word {
            "alias" => self.alias(cursor)?,
            "begin" => self.begin(cursor)?,
            "calibrate" => self.calibrate(cursor)?,
            "cartesian" => self.cartesian(cursor)?,
            "case" => self.case(cursor)?,
            "cs" => self.system(cursor)?,
            "data" => return self.order(cursor),
            "date" => self.date(cursor)?,
            "declination" => self.set_declination(cursor)?,
            "default" => self.default(cursor)?,
            "end" => self.end(cursor, blocks)?,
            "entrance" => {
                let station = self.station(cursor)?;
                self.draft.stations[station].is_entrance = true;
                self.hints.push((station, self.source, "entrance"));
            }
            "equate" => self.equate(cursor)?,
            "export" => self.export(cursor)?,
            "fix" => self.fix(cursor)?,
            "flags" => self.flags(cursor)?,
            "include" => {
                let place = *cursor;
                let Some(name) = cursor.quoted(&characters) else {
                    return Err(self.wrong(&place, "a quotation mark is missing", "add it"));
                };
                self.require_end(cursor)?;
                return self.include(&name, &place);
            }
            "infer" => self.infer(cursor)?,
            "prefix" => {
                self.warn(&before, "*prefix is out of use; *begin and *end are in its place");
                let survey = self.survey_name(cursor)?;
                if !survey.is_empty() {
                    self.note_surveys(&format!("{survey}."))?;
                }
                self.settings.prefix = survey.into();
            }
            "require" => self.require(cursor)?,
            "sd" => self.deviation(cursor)?,
            "set" => return self.set(cursor),
            "title" => {
                let place = *cursor;
                let Some(title) = cursor.quoted(&characters) else {
                    return Err(self.wrong(&place, "a quotation mark is missing", "add it"));
                };
                if self.settings.prefix.is_empty() || self.draft.title.is_none() {
                    self.draft.title.get_or_insert(title);
                }
            }
            "truncate" => self.truncate(cursor)?,
            "units" => self.units(cursor)?,
            "solve" => {
                self.warn(&before, "*solve is passed over: all is adjusted together");
                return Ok(());
            }
            "ref" => {
                let place = *cursor;
                if cursor.quoted(&characters).is_none() {
                    return Err(self.wrong(&place, "a quotation mark is missing", "add it"));
                }
            }
            "copyright" | "instrument" | "team" => return Ok(()),
            _ => {
                let wrong = format!("there is no command \"*{word}\"");
                return Err(self.wrong(&before, wrong, "correct it, or remove the line"));
            }
        }
        self.require_end(cursor)
    }

    fn alias(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let place = *cursor;
        let is_station = cursor.keyword(&characters) == "station";
        let (name, target) = (cursor.word(&characters), cursor.word(&characters));
        self.settings.dash_is_wall = match (is_station, name, target) {
            (true, b"-", b"..") => true,
            (true, b"-", b"") => false,
            _ => {
                let wrong = "this alias is not one that Survex knows";
                return Err(self.wrong(&place, wrong, "give *alias station - .."));
            }
        };
        Ok(())
    }

    fn begin(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        if self.blocks.len() >= MOST_BLOCKS {
            let wrong = format!("more than {MOST_BLOCKS} blocks are open");
            return Err(self.wrong(cursor, wrong, "end some of them"));
        }
        let place = *cursor;
        let mut survey = None;
        if !cursor.is_done(&self.settings.characters) {
            survey = Some(Rc::from(self.survey_name(cursor)?));
        }
        let (saved, source) = (self.settings.clone(), self.source);
        if let Some(survey) = &survey {
            self.enter(survey, &place)?;
            self.settings.prefix = Rc::clone(survey);
        }
        self.may_export = survey.is_some();
        self.blocks.push(Block { survey, saved, source });
        Ok(())
    }

    fn enter(&mut self, survey: &str, place: &Cursor<'_>) -> Result<(), Refusal> {
        // The root, which *begin \ enters, has no name and is no one survey's.
        if survey.is_empty() {
            return Ok(());
        }
        if self.draft.known(survey).is_some() {
            let wrong = format!("\"{survey}\" is both a station and a survey");
            return Err(self.wrong(place, wrong, "rename one of them"));
        }
        self.note_surveys(survey)?;
        self.draft.count_item();
        self.draft.require_room(self.source)?;
        let source = self.source;
        if let Some(Some(first)) = self.surveys.insert(survey.into(), Some(source)) {
            self.surveys.insert(survey.into(), Some(first));
            let first = self.draft.place(first, 0).map(|place| place.to_string());
            let first = first.unwrap_or_default();
            self.warn(place, format!("survey \"{survey}\" goes on here; it began at {first}"));
        }
        Ok(())
    }

    fn end(&mut self, cursor: &mut Cursor<'_>, blocks: usize) -> Result<(), Refusal> {
        let place = *cursor;
        if self.blocks.len() <= blocks {
            let wrong = "this *end has no *begin in its file";
            return Err(self.wrong(&place, wrong, "remove it, or add the *begin"));
        }
        let named = !cursor.is_done(&self.settings.characters);
        let Some(block) = self.blocks.pop() else { return Ok(()) };
        // The name is below the survey around the block.
        let inner = std::mem::replace(&mut self.settings.prefix, Rc::clone(&block.saved.prefix));
        let name = if named { Some(self.survey_name(cursor)) } else { None };
        self.settings.prefix = inner;
        match (name.transpose()?, &block.survey) {
            (None, Some(survey)) => {
                let text = format!("*end does not say the name of its survey, \"{survey}\"");
                self.warn(&place, text);
            }
            (Some(_), None) => {
                let wrong = "the *begin that this *end closes has no name";
                return Err(self.wrong(&place, wrong, "remove the name here, or add it there"));
            }
            (Some(name), Some(survey)) if name != **survey => {
                let begun = self.draft.place(block.source, 0);
                let begun = begun.map_or_else(String::new, |place| format!(", begun at {place}"));
                let wrong = format!("this *end is not of survey \"{survey}\"{begun}");
                return Err(self.wrong(&place, wrong, "correct one of the two names"));
            }
            _ => {}
        }
        self.require_end(cursor)?;
        self.settings = block.saved;
        self.end_passage();
        Ok(())
    }

    fn case(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        self.settings.case = match &*cursor.keyword(&self.settings.characters) {
            "preserve" => Case::Preserve,
            "toupper" => Case::Upper,
            "tolower" => Case::Lower,
            _ => return Err(self.wrong(&place, "no case", "give preserve, toupper or tolower")),
        };
        Ok(())
    }

    fn truncate(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let mut ahead = *cursor;
        if ahead.keyword(&self.settings.characters) == "off" {
            *cursor = ahead;
            self.settings.truncate = usize::MAX;
            return Ok(());
        }
        let length = self.plain_number(cursor)?;
        self.settings.truncate = if length < 1.0 { usize::MAX } else { length as usize };
        Ok(())
    }

    fn infer(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let place = *cursor;
        let what = cursor.keyword(&characters);
        let on = match &*cursor.keyword(&characters) {
            "on" => true,
            "off" => false,
            _ => return Err(self.wrong(&place, "neither on nor off", "give on or off")),
        };
        match &*what {
            "plumbs" => self.settings.infer.plumbs = on,
            "equates" => self.settings.infer.equates = on,
            "exports" => self.settings.infer.exports = on,
            _ => {
                let wrong = format!("\"{what}\" cannot be inferred");
                return Err(self.wrong(&place, wrong, "give plumbs, equates or exports"));
            }
        }
        Ok(())
    }

    fn flags(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let (mut on, mut any) = (true, false);
        while !any || !on || !cursor.is_done(&characters) {
            let place = *cursor;
            let word = cursor.keyword(&characters);
            if on && word == "not" {
                on = false;
                continue;
            }
            let Some(flag) = self.settings.flags.named(&word) else {
                let wrong = format!("there is no flag \"{word}\"");
                return Err(self.wrong(&place, wrong, "give duplicate, splay or surface"));
            };
            *flag = on;
            (on, any) = (true, true);
        }
        Ok(())
    }

    fn date(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        let text = String::from_utf8_lossy(cursor.word(&self.settings.characters)).into_owned();
        match date::days(&text) {
            Ok([first, last]) => self.settings.date = first.middle(last),
            Err(DateError::NoDate) => {
                let wrong = format!("\"{text}\" is no date");
                return Err(self.wrong(&place, wrong, "give one such as 2004.08.21"));
            }
            Err(DateError::Odd(why)) => self.warn(&place, format!("date {text}: {why}")),
            Err(DateError::Backwards) => {
                let wrong = format!("the dates {text} end before they begin");
                return Err(self.wrong(&place, wrong, "exchange them"));
            }
        }
        Ok(())
    }

    fn default(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        self.warn(&place, "*default is out of use; *units default and others are in its place");
        match &*cursor.keyword(&self.settings.characters) {
            "calibrate" => self.settings.default_calibration(),
            "data" => self.default_order(),
            "units" => self.settings.default_units(),
            _ => {
                let wrong = "there is no such setting";
                return Err(self.wrong(&place, wrong, "give calibrate, data or units"));
            }
        }
        Ok(())
    }

    fn require(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        let text = String::from_utf8_lossy(cursor.word(&self.settings.characters)).into_owned();
        let parts: Result<Vec<u32>, _> = text.split('.').map(str::parse).collect();
        match parts {
            Ok(parts) if parts.as_slice() <= &VERSION[..] => Ok(()),
            Ok(_) => {
                let wrong =
                    format!("the survey requires Survex {text}, and 1.4.22 is what is known here");
                Err(self.wrong(&place, wrong, "remove the *require if the survey does without"))
            }
            Err(_) => {
                Err(self.wrong(&place, format!("\"{text}\" is no version"), "give one such as 1.2"))
            }
        }
    }

    fn set(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        let word = cursor.keyword(&self.settings.characters);
        let Some(class) = Class::named(&word) else {
            let wrong = format!("there is no class of characters \"{word}\"");
            return Err(self.wrong(&place, wrong, "give one such as names or blank"));
        };
        cursor.skip_blanks(&self.settings.characters);
        let mut characters = Characters::clone(&self.settings.characters);
        characters.set(class, b"");
        while !cursor.is_done(&self.settings.characters) {
            // What ends a line from now on ends this one too.
            if class == Class::Eol && cursor.sees(class, &characters) {
                break;
            }
            let member = match cursor.rest() {
                [b'x' | b'X', a, b, ..] if a.is_ascii_hexdigit() && b.is_ascii_hexdigit() => {
                    let digit = |byte: u8| char::from(byte).to_digit(16).unwrap_or(0) as u8;
                    let member = digit(*a) * 16 + digit(*b);
                    cursor.next();
                    cursor.next();
                    member
                }
                [byte, ..] if byte.is_ascii_alphanumeric() => {
                    let wrong = "letters and digits are in no class";
                    return Err(self.wrong(cursor, wrong, "remove them"));
                }
                [byte, ..] => *byte,
                [] => break,
            };
            cursor.next();
            characters.add(class, member);
        }
        if class == Class::Eol {
            self.resume = Some(cursor.offset());
        }
        self.ever.merge(&characters);
        self.settings.characters = Rc::new(characters);
        Ok(())
    }
}
