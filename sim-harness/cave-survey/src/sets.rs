//! Keeps disjoint sets of numbers.

/// Disjoint sets of the numbers from 0 on.
pub(crate) struct Sets(Vec<usize>);

impl Sets {
    /// Makes a set of each number below `count`.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The number that stands for the set of `of`.
    pub(crate) fn root(&mut self, mut of: usize) -> usize {
        while self.0[of] != of {
            self.0[of] = self.0[self.0[of]];
            of = self.0[of];
        }
        of
    }

    /// Unites two sets; false where they were one.
    pub(crate) fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
        a != b
    }
}
