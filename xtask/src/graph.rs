//! The call graph of the firmware, and the depth of the stack below each function.

use std::collections::{BTreeMap, BTreeSet};

use virtual_crazyflie::cpu::effect::Instruction;

use crate::elf::Elf;
use crate::flow::{self, Call, Code, Flow, Target};

/// A function of the program.
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) address: u32,
    pub(crate) size: u32,
    /// Its effect on the stack, or the instruction that is not understood.
    pub(crate) flow: Result<Flow, String>,
}

/// The program's code.
pub(crate) struct Program {
    pub(crate) functions: Vec<Function>,
    instructions: BTreeMap<u32, Instruction>,
    by_address: BTreeMap<u32, usize>,
}

impl Program {
    pub(crate) fn new(elf: &Elf) -> Self {
        let instructions = &elf.instructions;
        let mut functions;
        // That a function never returns changes its callers' flow, so this repeats until no more do.
        let mut diverging = BTreeSet::new();
        loop {
            let analyse = |start: u32, size: u32| {
                flow::analyse(&Code {
                    start,
                    end: start + size,
                    instructions,
                    diverging: &diverging,
                })
            };
            functions = elf
                .functions
                .iter()
                .map(|symbol| Function {
                    name: symbol.name.clone(),
                    address: symbol.address,
                    size: symbol.size,
                    flow: analyse(symbol.address, symbol.size),
                })
                .collect::<Vec<_>>();
            let now: BTreeSet<u32> = functions
                .iter()
                .filter(|function| function.diverges())
                .map(|function| function.address)
                .collect();
            if now == diverging {
                break;
            }
            diverging = now;
        }
        let by_address = functions.iter().enumerate().map(|(i, f)| (f.address, i)).collect();
        Self { functions, instructions: instructions.clone(), by_address }
    }

    /// The function that begins at `address`.
    pub(crate) fn at(&self, address: u32) -> Option<usize> {
        self.by_address.get(&address).copied()
    }

    /// The functions of this name; a generic one can be there more than once.
    pub(crate) fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = usize> + 'a {
        self.functions.iter().enumerate().filter(move |(_, f)| f.name == name).map(|(i, _)| i)
    }

    /// The instructions from which control reaches an instruction that is not `exact` itself:
    /// branches on a condition, and other branches traced back until they are exact.
    pub(crate) fn ways_to(
        &self,
        function: usize,
        at: u32,
        exact: &dyn Fn(u32) -> bool,
    ) -> BTreeSet<u32> {
        let Function { address: start, size, .. } = self.functions[function];
        let code = || self.instructions.range(start..start + size).map(|(_, i)| i);
        let (mut ways, mut seen) = (BTreeSet::new(), BTreeSet::new());
        let mut waiting = vec![at];
        while let Some(at) = waiting.pop() {
            if !seen.insert(at) {
                continue;
            }
            if exact(at) {
                ways.insert(at);
                continue;
            }
            // The straight run of instructions that ends here, and a branch before it.
            let mut from = at;
            let before = self.instructions.range(start..at).rev().map(|(_, i)| i);
            for instruction in before {
                let follows = instruction.address + instruction.size == from;
                if !follows || flow::ends_block(instruction) || self.never_returns(instruction) {
                    break;
                }
                if flow::branch(instruction).is_some() {
                    ways.insert(instruction.address);
                    break;
                }
                from = instruction.address;
            }
            let leads_here = |instruction: &&Instruction| {
                flow::branch(instruction).is_some_and(|to| (from..=at).contains(&to))
            };
            for branch in code().filter(leads_here) {
                if flow::ends_block(branch) {
                    waiting.push(branch.address);
                } else {
                    ways.insert(branch.address);
                }
            }
        }
        ways
    }

    fn never_returns(&self, call: &Instruction) -> bool {
        let to = flow::called(call).and_then(|to| self.at(to));
        to.is_some_and(|to| self.functions[to].diverges())
    }

    /// Calls of known functions, with the depth of each.
    pub(crate) fn direct_calls(&self) -> Edges {
        let edges = self.functions.iter().map(|function| {
            let calls = function.flow.iter().flat_map(|flow| &flow.calls);
            calls
                .filter_map(|call| match call.to {
                    Target::At(address) => Some(call.edge(self.at(address)?)),
                    Target::Unknown => None,
                })
                .collect()
        });
        Edges(edges.collect())
    }
}

impl Function {
    /// Whether it never returns.
    pub(crate) fn diverges(&self) -> bool {
        self.flow.as_ref().is_ok_and(|flow| !flow.returns)
    }
}

/// A call, from the caller that it is listed under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub(crate) to: usize,
    /// The depth of the caller's stack at the call.
    pub(crate) depth: u32,
    /// The top of the stack, when the caller has changed over to another.
    pub(crate) stack: Option<u32>,
}

impl Call {
    pub(crate) fn edge(&self, to: usize) -> Edge {
        Edge { to, depth: self.depth, stack: self.stack }
    }
}

/// The calls of each function.
#[derive(Clone, Debug)]
pub(crate) struct Edges(pub(crate) Vec<Vec<Edge>>);

/// The depth of the stack below a function's entry, itself included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bound {
    pub(crate) bytes: u32,
    /// The call on the deepest way.
    pub(crate) through: Option<usize>,
}

impl Edges {
    /// Everything that can be reached, the beginnings included.
    pub(crate) fn reach(&self, from: impl IntoIterator<Item = usize>) -> BTreeSet<usize> {
        let mut seen = BTreeSet::new();
        let mut waiting: Vec<usize> = from.into_iter().collect();
        while let Some(at) = waiting.pop() {
            if seen.insert(at) {
                waiting.extend(self.0[at].iter().map(|edge| edge.to));
            }
        }
        seen
    }

    /// The depth below each function that can be reached from `roots`, or the first run of
    /// functions that call each other in a circle and of which none is bounded by `times`: how
    /// often it is at most active at once.
    pub(crate) fn bounds(
        &self,
        roots: &[usize],
        frames: &[u32],
        times: &dyn Fn(usize) -> Option<u32>,
    ) -> Result<Vec<Bound>, Vec<usize>> {
        let mut bounds = vec![Bound::default(); self.0.len()];
        for component in self.components(roots) {
            let members: BTreeSet<usize> = component.iter().copied().collect();
            let circular = |i: &usize| self.0[*i].iter().any(|edge| members.contains(&edge.to));
            if !component.iter().any(circular) {
                bounds[component[0]] = self.deepest(component[0], frames, &bounds, &|_| true);
                continue;
            }
            let Some((first, times)) = component.iter().find_map(|i| Some((*i, times(*i)?))) else {
                return Err(component);
            };
            // Without the calls of `first` no circle may be left; each time it is active costs at
            // most what it takes until it is called again.
            let order = self.order_without(first, &members).ok_or(component)?;
            for i in &order {
                bounds[*i] = self.deepest(*i, frames, &bounds, &|to| to != first);
            }
            let whole = bounds[first].bytes.saturating_mul(times.max(1));
            for i in &order {
                let bytes = if *i == first { whole } else { bounds[*i].bytes + whole };
                bounds[*i].bytes = bytes;
            }
        }
        Ok(bounds)
    }

    fn deepest(
        &self,
        of: usize,
        frames: &[u32],
        bounds: &[Bound],
        counts: &dyn Fn(usize) -> bool,
    ) -> Bound {
        let mut bound = Bound { bytes: frames[of], through: None };
        let counted = |edge: &&Edge| edge.stack.is_none() && counts(edge.to);
        for edge in self.0[of].iter().filter(counted) {
            let bytes = edge.depth + bounds[edge.to].bytes;
            if bytes > bound.bytes {
                bound = Bound { bytes, through: Some(edge.to) };
            }
        }
        bound
    }

    /// The members, callees first, when calls of `first` are left out; `None` if there is still a
    /// circle.
    fn order_without(&self, first: usize, members: &BTreeSet<usize>) -> Option<Vec<usize>> {
        let cut = Self(
            self.0
                .iter()
                .enumerate()
                .map(|(i, edges)| {
                    let kept = |edge: &&Edge| {
                        members.contains(&i) && members.contains(&edge.to) && edge.to != first
                    };
                    edges.iter().filter(kept).copied().collect()
                })
                .collect(),
        );
        let roots: Vec<usize> = members.iter().copied().collect();
        let components = cut.components(&roots);
        let self_call = |i: usize| cut.0[i].iter().any(|edge| edge.to == i);
        components
            .into_iter()
            .map(|component| match component.as_slice() {
                [one] if !self_call(*one) => Some(*one),
                _ => None,
            })
            .collect()
    }

    /// Functions that call each other in circles, together; callees before callers (Tarjan).
    fn components(&self, roots: &[usize]) -> Vec<Vec<usize>> {
        struct Search<'a> {
            edges: &'a Edges,
            index: BTreeMap<usize, usize>,
            low: BTreeMap<usize, usize>,
            path: Vec<usize>,
            found: Vec<Vec<usize>>,
        }
        impl Search<'_> {
            fn visit(&mut self, at: usize) -> usize {
                let index = self.index.len();
                self.index.insert(at, index);
                let mut low = index;
                self.path.push(at);
                for edge in &self.edges.0[at] {
                    if !self.index.contains_key(&edge.to) {
                        low = low.min(self.visit(edge.to));
                    } else if self.path.contains(&edge.to) {
                        low = low.min(self.index[&edge.to]);
                    }
                }
                self.low.insert(at, low);
                if low == index
                    && let Some(begin) = self.path.iter().position(|other| *other == at)
                {
                    self.found.push(self.path.split_off(begin));
                }
                low
            }
        }
        let mut search = Search {
            edges: self,
            index: BTreeMap::new(),
            low: BTreeMap::new(),
            path: vec![],
            found: vec![],
        };
        for root in roots {
            if !search.index.contains_key(root) {
                search.visit(*root);
            }
        }
        search.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::Vectors;
    use crate::synthetic::{self, branch, call, jump, ret, take};

    /// `calls[i]` are the callees of function i with the depth of each call.
    fn edges(calls: &[&[(usize, u32)]]) -> Edges {
        let edge = |(to, depth): &(usize, u32)| Edge { to: *to, depth: *depth, stack: None };
        Edges(calls.iter().map(|of| of.iter().map(edge).collect()).collect())
    }

    fn bytes(
        edges: &Edges,
        frames: &[u32],
        times: impl Fn(usize) -> Option<u32>,
    ) -> Result<Vec<u32>, Vec<usize>> {
        let bounds = edges.bounds(&[0], frames, &times)?;
        Ok(bounds.iter().map(|bound| bound.bytes).collect())
    }

    #[test]
    fn the_deepest_way_counts_and_not_the_longest() {
        // 0 calls 1 and 2 from different depths; 1 calls 3.
        let edges = edges(&[&[(1, 8), (2, 100)], &[(3, 8)], &[], &[]]);
        assert_eq!(bytes(&edges, &[100, 8, 40, 16], |_| None), Ok(vec![140, 24, 40, 16]));
        let bounds = edges.bounds(&[0], &[100, 8, 40, 16], &|_| None).unwrap();
        assert_eq!(bounds[0].through, Some(2));
    }

    #[test]
    fn a_circle_without_a_bound_is_an_error_and_only_where_it_is_reached() {
        let circle = edges(&[&[(1, 8)], &[(2, 8)], &[(1, 8)]]);
        let mut named = bytes(&circle, &[8, 8, 8], |_| None).unwrap_err();
        named.sort_unstable();
        assert_eq!(named, [1, 2]);
        let apart = edges(&[&[], &[(1, 8)]]);
        assert_eq!(bytes(&apart, &[8, 8], |_| None), Ok(vec![8, 0]));
    }

    #[test]
    fn a_bounded_circle_costs_as_often_as_it_goes_round() {
        // 1 calls itself, three times at most, then 2.
        let itself = edges(&[&[(1, 8)], &[(1, 16), (2, 16)], &[]]);
        let three = |i| (i == 1).then_some(3);
        assert_eq!(bytes(&itself, &[8, 16, 4], three), Ok(vec![8 + 3 * 20, 3 * 20, 4]));
        // 1 and 2 call each other; 2 is entered first.
        let two = edges(&[&[(2, 8)], &[(2, 16)], &[(1, 32)]]);
        let is = bytes(&two, &[8, 16, 32], three).unwrap();
        // Each round from 1 to 1 takes at least 48; from 2 there is one 32 more.
        assert!(is[1] >= 3 * 16 + 2 * 32, "{is:?}");
        assert!(is[0] >= 8 + 32 + is[1], "{is:?}");
    }

    #[test]
    fn two_circles_need_two_bounds() {
        let edges = edges(&[&[(1, 8)], &[(1, 8), (2, 8)], &[(1, 8), (2, 8)]]);
        assert!(bytes(&edges, &[8, 8, 8], |i| (i == 1).then_some(2)).is_err());
    }

    #[test]
    fn what_another_stack_carries_is_not_on_this_one() {
        let mut edges = edges(&[&[(1, 8)], &[(2, 8)], &[]]);
        edges.0[1][0].stack = Some(0x1000);
        assert_eq!(bytes(&edges, &[8, 16, 100], |_| None), Ok(vec![24, 16, 100]));
    }

    #[test]
    fn a_call_in_common_is_traced_back_to_the_branches() {
        let elf = synthetic::elf(
            Vectors { stack: 0, handlers: vec![] },
            vec![
                (
                    "f",
                    0x100,
                    vec![
                        branch(0x0800_4106),
                        branch(0x0800_410C),
                        ret(),
                        take(0),
                        jump(0x0800_410E),
                        call(0x0800_4200),
                        take(0),
                        call(0x0800_4200),
                    ],
                ),
                ("panic", 0x200, vec![jump(0x0800_4200)]),
            ],
            &[],
        );
        let program = Program::new(&elf);
        let ways = |exact: &[u32]| program.ways_to(0, 0x0800_410E, &|at| exact.contains(&at));
        assert_eq!(ways(&[]), BTreeSet::from([0x0800_4100, 0x0800_4102]));
        assert_eq!(ways(&[0x0800_4108]), BTreeSet::from([0x0800_4102, 0x0800_4108]));
        assert_eq!(ways(&[0x0800_410E]), BTreeSet::from([0x0800_410E]));
    }

    #[test]
    fn reaching_follows_calls() {
        let edges = edges(&[&[(1, 0)], &[(0, 0)], &[(1, 0)]]);
        assert_eq!(edges.reach([0]), BTreeSet::from([0, 1]));
        assert_eq!(edges.reach([2]), BTreeSet::from([0, 1, 2]));
    }
}
