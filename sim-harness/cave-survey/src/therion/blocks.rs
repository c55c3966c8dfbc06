//! Opens and closes the blocks of a file: surveys, centrelines and groups. What has no centreline is
//! passed over.

use std::borrow::Cow;

use super::Reader;
use super::bearings::Declinations;
use super::centreline::Centreline;
use super::options::{AngleUnit, angle_unit};
use crate::error::Refusal;
use crate::survey::Source;

/// The most blocks that are open at once.
const MOST_BLOCKS: usize = 200;

/// The kind of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlockKind {
    Survey,
    Centreline,
    Group,
    /// A file's part of a configuration that is written into it.
    Source,
}

impl BlockKind {
    /// The word that begins such a block.
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Survey => "survey",
            Self::Centreline => "centreline",
            Self::Group => "group",
            Self::Source => "source",
        }
    }
}

/// A block that is open.
pub(super) struct Block {
    pub(super) kind: BlockKind,
    pub(super) source: Source,
    /// The name of a survey.
    name: String,
    /// Whether a survey is a level of the names in it.
    is_level: bool,
    /// The declinations that a survey gives its centrelines.
    declinations: Declinations,
    /// The settings that come back at the end of a group.
    saved: Option<Centreline>,
}

/// Blocks that have no centreline, each with the word that ends it.
const SKIPPED: &[(&str, &str)] = &[
    ("comment", "endcomment"),
    ("grade", "endgrade"),
    ("layout", "endlayout"),
    ("lookup", "endlookup"),
    ("map", "endmap"),
    ("scan", "endscan"),
    ("scrap", "endscrap"),
    ("surface", "endsurface"),
];

/// Commands of one line that move no station, those of configuration files among them.
const PASSED_OVER: &[&str] = &[
    "cs",
    "export",
    "join",
    "language",
    "log",
    "loop-closure",
    "maps",
    "maps-offset",
    "output",
    "select",
    "setup3d",
    "sketch-colors",
    "sketch-warp",
    "system",
    "text",
    "title",
    "unselect",
];

/// Whether the lines behind a `revise` belong to it, up to its end.
fn revises_lines<'t>(rest: impl Iterator<Item = (u32, Cow<'t, str>)>) -> bool {
    /// The most lines of a revision.
    const MOST: usize = 1000;
    for (_, line) in rest.take(MOST) {
        match line.split_whitespace().next() {
            Some("endrevise") => return true,
            Some("revise" | "survey" | "endsurvey") => return false,
            _ => {}
        }
    }
    false
}

impl Reader<'_> {
    pub(super) fn begin(&mut self, kind: BlockKind) -> Result<&mut Block, Refusal> {
        if self.blocks.len() >= MOST_BLOCKS {
            let wrong = format!("more than {MOST_BLOCKS} blocks are open");
            return Err(self.wrong(wrong, "end some of them"));
        }
        let (name, source) = (String::new(), self.source);
        let declinations = Declinations::default();
        let block = Block { kind, source, name, is_level: false, declinations, saved: None };
        self.blocks.push(block);
        let last = self.blocks.len() - 1;
        Ok(&mut self.blocks[last])
    }

    /// Closes the innermost block, which must be of the kind.
    pub(super) fn close(&mut self, kind: BlockKind) -> Result<Block, Refusal> {
        match self.blocks.pop_if(|block| block.kind == kind) {
            Some(block) => Ok(block),
            None => {
                let word = kind.word();
                let remedy = match self.blocks.last() {
                    Some(open) => format!("end the {} before it", open.kind.word()),
                    None => "remove it".into(),
                };
                Err(self.wrong(format!("this end{word} has no {word} around it"), remedy))
            }
        }
    }

    /// Carries out a command outside a centreline.
    pub(super) fn in_survey<'t, I: Iterator<Item = (u32, Cow<'t, str>)>>(
        &mut self,
        key: &str,
        arguments: &[String],
        rest: impl Fn() -> I,
    ) -> Result<(), Refusal> {
        match key {
            "survey" => self.begin_survey(arguments),
            "endsurvey" => self.end_survey(arguments),
            "centreline" | "centerline" => self.begin_centreline(),
            "equate" => self.equate(arguments),
            "source" if arguments.is_empty() => self.begin(BlockKind::Source).map(drop),
            "endsource" => self.close(BlockKind::Source).map(drop),
            "source" => {
                arguments.iter().try_for_each(|name| self.input(std::slice::from_ref(name)))
            }
            "import" => {
                let name = arguments.first().map_or("", String::as_str);
                self.remark(format!("import of \"{name}\" is passed over: give that file itself"));
                Ok(())
            }
            "revise" => {
                self.remark("revise is passed over");
                // Only some objects have lines of their own to revise.
                if revises_lines(rest()) {
                    self.skipped = Some(("endrevise".into(), self.source));
                }
                Ok(())
            }
            _ if PASSED_OVER.contains(&key) => Ok(()),
            _ => match SKIPPED.iter().find(|(begin, _)| *begin == key) {
                Some((_, end)) => {
                    self.skipped = Some(((*end).into(), self.source));
                    Ok(())
                }
                None => {
                    let wrong = format!("there is no command \"{key}\" outside a centreline");
                    Err(self.wrong(wrong, "correct it, or put it into a centreline"))
                }
            },
        }
    }

    /// Reads `survey name -title … -declination … -entrance … -namespace off`.
    fn begin_survey(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let Some((name, options)) = arguments.split_first() else {
            return Err(self.wrong("a survey has no name", "give it"));
        };
        let allowed = |it: char| it.is_ascii_alphanumeric() || "_-/".contains(it) || !it.is_ascii();
        if name.is_empty() || !name.chars().all(allowed) {
            let wrong = format!("\"{name}\" is no name of a survey");
            return Err(self.wrong(wrong, "give letters, digits, _ and -"));
        }
        let option = |key: &str| {
            let at = options.iter().position(|word| word == key)?;
            options.get(at + 1).map(String::as_str)
        };
        let inherited = self.inherited_declinations();
        let declinations = match option("-declination") {
            Some(text) => self.declinations(text, options)?,
            None => Declinations::default(),
        };
        if let Some(title) = option("-title").filter(|title| !title.is_empty()) {
            self.draft.title.get_or_insert_with(|| title.to_owned());
        }
        let is_level = option("-namespace") != Some("off");
        if is_level {
            self.enter(name)?;
        }
        let block = self.begin(BlockKind::Survey)?;
        name.clone_into(&mut block.name);
        block.is_level = is_level;
        block.declinations = if declinations.is_empty() { inherited } else { declinations };
        if let Some(entrance) = option("-entrance") {
            let station = self.station(entrance)?;
            self.draft.stations[station].is_entrance = true;
        }
        Ok(())
    }

    /// Reads the declination of a survey: `[angle unit]`, or `[date angle date angle … unit]`.
    fn declinations(&self, text: &str, options: &[String]) -> Result<Declinations, Refusal> {
        let words = super::words::split(text);
        // Without brackets, the unit is the next word.
        let behind = options.iter().position(|word| word == text).and_then(|n| options.get(n + 1));
        let (unit, rest) = match words.as_slice() {
            [none] if super::words::is_omitted(none) => return Ok(Declinations::default()),
            [_] => (behind.cloned().unwrap_or_default(), words.as_slice()),
            [rest @ .., unit] => (unit.clone(), rest),
            [] => return Ok(Declinations::default()),
        };
        let radians = angle_unit(&unit).and_then(AngleUnit::radians);
        let read = radians.and_then(|radians| Declinations::read(rest, radians));
        read.ok_or_else(|| {
            self.wrong(format!("\"{text}\" is no declination"), "give one such as [3.5 degrees]")
        })
    }

    fn end_survey(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let block = self.close(BlockKind::Survey)?;
        if let Some(name) = arguments.first().filter(|name| **name != block.name) {
            let wrong =
                format!("this endsurvey names \"{name}\", and survey \"{}\" is open", block.name);
            return Err(self.wrong(wrong, "correct one of the two names"));
        }
        if block.is_level {
            self.names.path.pop();
        }
        Ok(())
    }

    fn begin_centreline(&mut self) -> Result<(), Refusal> {
        let declinations = self.inherited_declinations();
        self.begin(BlockKind::Centreline)?;
        self.centreline = Some(Centreline { declinations, ..Centreline::default() });
        Ok(())
    }

    /// The declinations of the innermost survey.
    fn inherited_declinations(&self) -> Declinations {
        let survey = self.blocks.iter().rev().find(|block| block.kind == BlockKind::Survey);
        survey.map(|block| block.declinations.clone()).unwrap_or_default()
    }

    pub(super) fn begin_group(&mut self) -> Result<(), Refusal> {
        let saved = self.centreline.clone();
        self.begin(BlockKind::Group)?.saved = saved;
        Ok(())
    }

    pub(super) fn end_group(&mut self) -> Result<(), Refusal> {
        let block = self.close(BlockKind::Group)?;
        self.centreline = block.saved;
        Ok(())
    }

    /// Notes that stations are the same.
    pub(super) fn equate(&mut self, names: &[String]) -> Result<(), Refusal> {
        let [first, others @ ..] = names else {
            return Err(self.wrong("equate names no station", "name two"));
        };
        if others.is_empty() {
            return Err(self.wrong("equate names only one station", "name the other too"));
        }
        let first = self.station(first)?;
        for other in others {
            let other = self.station(other)?;
            if other == first {
                self.remark("a station is equated to itself");
            } else {
                self.draft.equate(first, other, self.source);
            }
        }
        Ok(())
    }
}
