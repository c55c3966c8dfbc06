//! Shapes, statics and arguments from an ELF's DWARF, as rustc writes it.
//!
//! An enum is a structure with a variant part, whose discriminant is a member and whose variants
//! are members of the variants' names (DWARF 5, 5.7.10). A variant without a number of its own is
//! the one that all other numbers mean: rustc's niche.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use gimli::{AttributeValue, DebuggingInformationEntry as Die, Operation, UnitOffset};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection};

use super::shape::{Discriminant, Kind, Member, Shape, Target, Variant};
use super::{Arguments, Inspector, Location, Parameter, Place};

type Bytes<'a> = gimli::EndianSlice<'a, gimli::LittleEndian>;
type Dwarf<'a> = gimli::Dwarf<Bytes<'a>>;
type Unit<'a> = gimli::Unit<Bytes<'a>>;
type Entry<'a> = Die<Bytes<'a>>;

pub(super) fn read(
    elf: &[u8],
    variables: &[&str],
    functions: &[&str],
) -> Result<Inspector, String> {
    let file: ElfFile32<'_> = ElfFile32::parse(elf).map_err(|why| format!("no ELF: {why}"))?;
    let section = |id: gimli::SectionId| -> Result<Bytes<'_>, gimli::Error> {
        let data = file.section_by_name(id.name()).and_then(|section| section.data().ok());
        Ok(Bytes::new(data.unwrap_or_default(), gimli::LittleEndian))
    };
    let dwarf = Dwarf::load(section).map_err(|why| format!("debug information: {why}"))?;
    let all = variables.is_empty() && functions.is_empty();
    let wanted = |names: &[&str], path: &str| all || names.contains(&path);
    let mut inspector = Inspector::default();
    let mut units = dwarf.units();
    while let Some(header) = units.next().map_err(wrong)? {
        let unit = dwarf.unit(header).map_err(wrong)?;
        let types = Types::of(&dwarf, &unit);
        let mut seen = HashSet::new();
        let mut entries = unit.entries();
        while let Some(entry) = entries.next_dfs().map_err(wrong)? {
            let tag = entry.tag();
            if tag != gimli::DW_TAG_variable && tag != gimli::DW_TAG_subprogram {
                continue;
            }
            let Some(path) = path_of(&dwarf, &unit, entry) else { continue };
            if !seen.insert((tag, path.clone())) {
                continue;
            }
            if tag == gimli::DW_TAG_variable && wanted(variables, &path) {
                if let Some(place) = types.variable(entry) {
                    inspector.variables.insert(path, place);
                }
            } else if tag == gimli::DW_TAG_subprogram
                && wanted(functions, &path)
                && let Some(arguments) = types.function(entry)
            {
                inspector.functions.insert(path, arguments);
            }
        }
        inspector.shapes.extend(types.known.into_inner().into_values().flatten());
    }
    if inspector.variables.is_empty() && inspector.functions.is_empty() {
        return Err("there is no debug information in it".into());
    }
    Ok(inspector)
}

fn wrong(why: gimli::Error) -> String {
    format!("debug information: {why}")
}

/// A static's or a function's path, from its linkage name: without a crate's hash, without
/// generics.
fn path_of(dwarf: &Dwarf<'_>, unit: &Unit<'_>, entry: &Entry<'_>) -> Option<String> {
    let name = entry.attr_value(gimli::DW_AT_linkage_name)?;
    let name = dwarf.attr_string(unit, name).ok()?;
    Some(format!("{:#}", rustc_demangle::demangle(name.to_string().ok()?)))
}

/// The types of one unit, made as they are asked for.
struct Types<'u, 'a> {
    dwarf: &'u Dwarf<'a>,
    unit: &'u Unit<'a>,
    /// `None` while a type is being made, and for what has no shape.
    known: RefCell<HashMap<UnitOffset, Option<Arc<Shape>>>>,
}

impl<'u, 'a> Types<'u, 'a> {
    fn of(dwarf: &'u Dwarf<'a>, unit: &'u Unit<'a>) -> Self {
        Self { dwarf, unit, known: RefCell::default() }
    }

    fn variable(&self, entry: &Entry<'a>) -> Option<Place> {
        let AttributeValue::Exprloc(location) = entry.attr_value(gimli::DW_AT_location)? else {
            return None;
        };
        let mut operations = location.operations(self.unit.encoding());
        let Operation::Address { address } = operations.next().ok()?? else { return None };
        Some(Place { shape: self.type_of(entry)?, address: address as u32 })
    }

    fn function(&self, entry: &Entry<'a>) -> Option<Arguments> {
        let AttributeValue::Addr(entry_point) = entry.attr_value(gimli::DW_AT_low_pc)? else {
            return None;
        };
        let mut found = Vec::new();
        let mut tree = self.unit.entries_tree(Some(entry.offset())).ok()?;
        let mut children = tree.root().ok()?.children();
        while let Some(child) = children.next().ok()? {
            let child = child.entry();
            if child.tag() == gimli::DW_TAG_formal_parameter {
                let ranges = self.locations(child)?;
                found.push((self.name(child)?, self.type_of(child)?, ranges));
            }
        }
        let starts = found.iter().flat_map(|(_, _, ranges)| ranges.iter().map(|range| range.0));
        let mut starts: Vec<_> = starts.chain([entry_point]).collect();
        starts.sort_unstable();
        let at = |ranges: &[(u64, u64, Location)], pc: u64| {
            ranges.iter().find(|range| range.0 <= pc && pc < range.1).map(|range| range.2)
        };
        let ready = starts
            .into_iter()
            .find(|&pc| found.iter().all(|(_, _, ranges)| at(ranges, pc).is_some()))?;
        let parameters = found
            .into_iter()
            .filter_map(|(name, shape, ranges)| {
                Some(Parameter { name, shape, location: at(&ranges, ready)? })
            })
            .collect();
        Some(Arguments {
            entry: entry_point as u32,
            ready: ready as u32,
            parameters,
            returns: self.type_of(entry),
        })
    }

    /// Where an argument is, from where to where. Only registers, and memory that a register
    /// points to, are told.
    fn locations(&self, entry: &Entry<'a>) -> Option<Vec<(u64, u64, Location)>> {
        let value = entry.attr_value(gimli::DW_AT_location)?;
        if let AttributeValue::Exprloc(expression) = value {
            let location = self.location(expression)?;
            return Some(vec![(0, u64::MAX, location)]);
        }
        let mut list = self.dwarf.attr_locations(self.unit, value).ok()??;
        let mut ranges = Vec::new();
        while let Some(item) = list.next().ok()? {
            if let Some(location) = self.location(item.data) {
                ranges.push((item.range.begin, item.range.end, location));
            }
        }
        Some(ranges)
    }

    fn location(&self, expression: gimli::Expression<Bytes<'a>>) -> Option<Location> {
        let mut operations = expression.operations(self.unit.encoding());
        let first = operations.next().ok()??;
        let last = operations.next().ok()?.is_none();
        match first {
            Operation::Register { register } if last && register.0 < 16 => {
                Some(Location::Register(register.0 as u8))
            }
            Operation::RegisterOffset { register, offset, .. } if last && register.0 < 16 => {
                Some(Location::Based(register.0 as u8, offset as i32))
            }
            _ => None,
        }
    }

    fn name(&self, entry: &Entry<'a>) -> Option<String> {
        let name = self.dwarf.attr_string(self.unit, entry.attr_value(gimli::DW_AT_name)?).ok()?;
        Some(name.to_string().ok()?.to_owned())
    }

    fn number(entry: &Entry<'a>, name: gimli::DwAt) -> Option<u64> {
        entry.attr_value(name)?.udata_value()
    }

    fn reference(entry: &Entry<'a>, name: gimli::DwAt) -> Option<UnitOffset> {
        match entry.attr_value(name)? {
            AttributeValue::UnitRef(offset) => Some(offset),
            _ => None,
        }
    }

    fn type_of(&self, entry: &Entry<'a>) -> Option<Arc<Shape>> {
        self.shape(Self::reference(entry, gimli::DW_AT_type)?)
    }

    fn shape(&self, at: UnitOffset) -> Option<Arc<Shape>> {
        if let Some(known) = self.known.borrow().get(&at) {
            return known.clone();
        }
        self.known.borrow_mut().insert(at, None);
        let shape = self.make(at).map(Arc::new);
        self.known.borrow_mut().insert(at, shape.clone());
        if let Some(shape) = &shape
            && let Kind::Pointer { target } = &shape.kind
        {
            self.aim(at, target);
        }
        shape
    }

    /// After the pointer itself is known, because its target may point back to it.
    fn aim(&self, at: UnitOffset, target: &Target) {
        let pointee = self.unit.entry(at).ok().and_then(|entry| self.type_of(&entry));
        if let Some(shape) = pointee {
            target.set(&shape);
        }
    }

    fn make(&self, at: UnitOffset) -> Option<Shape> {
        let entry = self.unit.entry(at).ok()?;
        let name = self.name(&entry).unwrap_or_default();
        let mut size = Self::number(&entry, gimli::DW_AT_byte_size).unwrap_or(0) as u32;
        let kind = match entry.tag() {
            gimli::DW_TAG_base_type => self.base(&entry)?,
            // A caller that reads a member of a union like `MaybeUninit` knows that it is there.
            gimli::DW_TAG_structure_type | gimli::DW_TAG_union_type => self.structure(at)?,
            gimli::DW_TAG_enumeration_type => Kind::Names { names: self.enumerators(at)? },
            gimli::DW_TAG_pointer_type => {
                size = 4;
                Kind::Pointer { target: Target::default() }
            }
            gimli::DW_TAG_array_type => {
                let (element, count) = (self.type_of(&entry)?, self.count(at)?);
                size = element.size * count;
                Kind::Array { element, count }
            }
            _ => Kind::Opaque,
        };
        Some(Shape { name, size, kind })
    }

    fn base(&self, entry: &Entry<'a>) -> Option<Kind> {
        let AttributeValue::Encoding(encoding) = entry.attr_value(gimli::DW_AT_encoding)? else {
            return None;
        };
        Some(match encoding {
            gimli::DW_ATE_boolean => Kind::Bool,
            gimli::DW_ATE_UTF => Kind::Char,
            gimli::DW_ATE_float => Kind::Float,
            gimli::DW_ATE_signed | gimli::DW_ATE_signed_char => Kind::Signed,
            _ => Kind::Unsigned,
        })
    }

    /// The entries right below one.
    fn children(&self, at: UnitOffset) -> Option<Vec<Entry<'a>>> {
        let mut tree = self.unit.entries_tree(Some(at)).ok()?;
        let mut children = tree.root().ok()?.children();
        let mut found = Vec::new();
        while let Some(child) = children.next().ok()? {
            found.push(child.entry().clone());
        }
        Some(found)
    }

    fn structure(&self, at: UnitOffset) -> Option<Kind> {
        let children = self.children(at)?;
        if let Some(part) = children.iter().find(|c| c.tag() == gimli::DW_TAG_variant_part) {
            return self.choice(part);
        }
        let members = children.iter().filter(|child| child.tag() == gimli::DW_TAG_member);
        // A field of a type that cannot be read is left out.
        let members = members.filter_map(|child| self.member(child)).collect();
        Some(Kind::Structure { members })
    }

    fn member(&self, entry: &Entry<'a>) -> Option<Member> {
        Some(Member {
            name: self.name(entry)?,
            offset: Self::number(entry, gimli::DW_AT_data_member_location).unwrap_or(0) as u32,
            shape: self.type_of(entry)?,
        })
    }

    fn choice(&self, part: &Entry<'a>) -> Option<Kind> {
        let discriminant = match Self::reference(part, gimli::DW_AT_discr) {
            None => None,
            Some(at) => {
                let member = self.unit.entry(at).ok()?;
                let offset = Self::number(&member, gimli::DW_AT_data_member_location).unwrap_or(0);
                Some((offset as u32, self.type_of(&member)?.size))
            }
        };
        let mut variants = Vec::new();
        for child in self.children(part.offset())? {
            if child.tag() != gimli::DW_TAG_variant {
                continue;
            }
            let size = discriminant.map_or(8, |(_, size)| size);
            let number = child.attr_value(gimli::DW_AT_discr_value);
            let number = number.and_then(|value| masked(&value, size));
            let members = self.children(child.offset())?;
            let member = members.iter().find(|child| child.tag() == gimli::DW_TAG_member)?;
            let (name, shape) = (self.name(member)?, self.type_of(member)?);
            variants.push(Variant { number, name, shape });
        }
        Some(Kind::Choice { discriminant: Discriminant(discriminant), variants })
    }

    fn enumerators(&self, at: UnitOffset) -> Option<Vec<(u64, String)>> {
        let entry = self.unit.entry(at).ok()?;
        let size = Self::number(&entry, gimli::DW_AT_byte_size)? as u32;
        let names = self.children(at)?;
        let names = names.iter().filter(|child| child.tag() == gimli::DW_TAG_enumerator);
        names
            .map(|child| {
                let value = child.attr_value(gimli::DW_AT_const_value)?;
                Some((masked(&value, size)?, self.name(child)?))
            })
            .collect()
    }

    fn count(&self, at: UnitOffset) -> Option<u32> {
        let range = self.children(at)?;
        let range = range.iter().find(|child| child.tag() == gimli::DW_TAG_subrange_type)?;
        Self::number(range, gimli::DW_AT_count).map(|count| count as u32)
    }
}

/// A constant as so many bytes hold it, whatever its sign.
fn masked(value: &AttributeValue<Bytes<'_>>, size: u32) -> Option<u64> {
    let bits = match value {
        AttributeValue::Sdata(value) => *value as u64,
        other => other.udata_value()?,
    };
    Some(if size >= 8 { bits } else { bits & ((1 << (8 * size)) - 1) })
}
