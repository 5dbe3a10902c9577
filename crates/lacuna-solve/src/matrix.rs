//! Symmetric sparse matrices as sorted columns of their lower triangle.

use crate::SolveError;

/// One addend of a matrix entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triplet {
    /// Row.
    pub row: u32,
    /// Column.
    pub column: u32,
    /// Addend.
    pub value: f64,
}

/// A symmetric matrix: the lower triangle in compressed columns, rows ascending, every diagonal entry present.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseSymmetric {
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl SparseSymmetric {
    /// Sums triplets. An off-diagonal pair is given once, on either side of the diagonal. Addends of one entry are
    /// summed in the order in which they come, so equal input gives equal bits.
    ///
    /// # Errors
    /// [`SolveError::Malformed`] if an index is out of range, [`SolveError::TooLarge`] over 2^32 entries.
    pub fn from_triplets(order: usize, triplets: &[Triplet]) -> Result<Self, SolveError> {
        let mut lower: Vec<Triplet> = triplets.iter().map(into_lower).collect();
        if lower.iter().any(|t| t.row as usize >= order) {
            return Err(malformed("a triplet's index is out of range"));
        }
        lower.extend((0..order as u32).map(|i| Triplet { row: i, column: i, value: 0.0 }));
        lower.sort_by_key(|t| (t.column, t.row));
        let mut starts = vec![0u32; order + 1];
        let mut rows: Vec<u32> = Vec::with_capacity(lower.len());
        let mut values: Vec<f64> = Vec::with_capacity(lower.len());
        let mut last = None;
        for t in &lower {
            if last == Some((t.column, t.row)) {
                if let Some(sum) = values.last_mut() {
                    *sum += t.value;
                }
                continue;
            }
            last = Some((t.column, t.row));
            rows.push(t.row);
            values.push(t.value);
            starts[t.column as usize + 1] = narrow(rows.len(), order)?;
        }
        Ok(Self { starts, rows, values })
    }

    /// Takes finished columns: column `j` is `rows[starts[j]..starts[j + 1]]`, ascending, its first row `j` itself.
    ///
    /// # Errors
    /// [`SolveError::Malformed`] if the columns are anything else.
    pub fn from_sorted_columns(
        starts: Vec<u32>,
        rows: Vec<u32>,
        values: Vec<f64>,
    ) -> Result<Self, SolveError> {
        let ends_well = starts.first() == Some(&0)
            && starts.last().is_some_and(|&e| e as usize == rows.len())
            && starts.windows(2).all(|w| w[0] < w[1])
            && rows.len() == values.len();
        if !ends_well {
            return Err(malformed("column starts do not fit the entries"));
        }
        let order = starts.len() - 1;
        for j in 0..order {
            let column = &rows[starts[j] as usize..starts[j + 1] as usize];
            let sorted = column.windows(2).all(|w| w[0] < w[1]);
            let last = column.last().is_some_and(|&r| (r as usize) < order);
            if !(sorted && last && column[0] as usize == j) {
                return Err(malformed("a column is not sorted or lacks its diagonal entry"));
            }
        }
        Ok(Self { starts, rows, values })
    }

    /// The same matrix with `addends` on entries that it has; the pattern stays. An off-diagonal pair is given once, on
    /// either side of the diagonal.
    ///
    /// # Errors
    /// [`SolveError::Malformed`] if an addend is for an entry that the matrix does not have.
    pub fn plus(&self, addends: impl IntoIterator<Item = Triplet>) -> Result<Self, SolveError> {
        let mut sum = self.clone();
        for t in addends {
            let Triplet { row, column, value } = into_lower(&t);
            let at =
                self.find(row, column).ok_or_else(|| malformed("an addend is outside of the pattern"))?;
            sum.values[at] += value;
        }
        Ok(sum)
    }

    /// Index of an entry of the lower triangle.
    fn find(&self, row: u32, column: u32) -> Option<usize> {
        if column as usize >= self.order() {
            return None;
        }
        let range = self.starts[column as usize] as usize..self.starts[column as usize + 1] as usize;
        // The first entry of a column is the one on the diagonal.
        if row == column {
            return Some(range.start);
        }
        self.rows[range.clone()].binary_search(&row).ok().map(|k| range.start + k)
    }

    /// The first `count` unknowns alone, all others being held at `held` (one value each, in order): the matrix that is
    /// left, and what moves to the right-hand side.
    ///
    /// # Errors
    /// [`SolveError::WrongLength`] unless `count` and `held` make up the order.
    pub fn leading(&self, count: usize, held: &[f64]) -> Result<(Self, Vec<f64>), SolveError> {
        if count + held.len() != self.order() {
            return Err(SolveError::WrongLength { length: count + held.len(), order: self.order() });
        }
        let (mut starts, mut rows, mut values) = (vec![0u32], vec![], vec![]);
        let mut moved = vec![0.0; count];
        for j in 0..count {
            for (row, value) in self.column(j) {
                match (row as usize).checked_sub(count) {
                    Some(k) => moved[j] -= value * held[k],
                    None => {
                        rows.push(row);
                        values.push(value);
                    }
                }
            }
            starts.push(narrow(rows.len(), count)?);
        }
        Ok((Self { starts, rows, values }, moved))
    }

    /// The entry on the diagonal of column `j`.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        self.values[self.starts[j] as usize]
    }

    /// Number of rows and columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of stored entries (lower triangle).
    #[must_use]
    pub fn entry_count(&self) -> usize {
        self.rows.len()
    }

    /// Memory of the entries, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (size_of::<u32>() * (self.starts.capacity() + self.rows.capacity())
            + size_of::<f64>() * self.values.capacity()) as u64
    }

    /// Rows and values of column `j` from the diagonal downwards.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[j] as usize..self.starts[j + 1] as usize;
        self.rows[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    /// The product with a vector.
    ///
    /// # Errors
    /// [`SolveError::WrongLength`] if the vector does not have one number a column.
    pub fn multiply(&self, x: &[f64]) -> Result<Vec<f64>, SolveError> {
        let order = self.order();
        if x.len() != order {
            return Err(SolveError::WrongLength { length: x.len(), order });
        }
        let mut product = vec![0.0; order];
        for j in 0..order {
            for (i, value) in self.column(j) {
                product[i as usize] += value * x[j];
                if i as usize != j {
                    product[j] += value * x[i as usize];
                }
            }
        }
        Ok(product)
    }

    pub(crate) fn starts(&self) -> &[u32] {
        &self.starts
    }

    pub(crate) fn rows(&self) -> &[u32] {
        &self.rows
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// A copy whose diagonal entries are enlarged by the given share of themselves.
    pub(crate) fn shifted(&self, share: f64) -> Self {
        let mut copy = self.clone();
        for j in 0..self.order() {
            let at = self.starts[j] as usize;
            copy.values[at] += copy.values[at].abs() * share;
        }
        copy
    }

    /// True if both matrices have entries at the same places.
    pub(crate) fn has_pattern_of(&self, other: &Self) -> bool {
        self.starts == other.starts && self.rows == other.rows
    }
}

fn into_lower(t: &Triplet) -> Triplet {
    Triplet { row: t.row.max(t.column), column: t.row.min(t.column), value: t.value }
}

fn malformed(what: &str) -> SolveError {
    SolveError::Malformed { what: what.to_owned() }
}

fn narrow(count: usize, order: usize) -> Result<u32, SolveError> {
    u32::try_from(count)
        .map_err(|_| SolveError::TooLarge { order, what: "more than 2^32 matrix entries".to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triplet(row: u32, column: u32, value: f64) -> Triplet {
        Triplet { row, column, value }
    }

    fn path() -> SparseSymmetric {
        let entries = [triplet(0, 0, 2.0), triplet(1, 0, -1.0), triplet(1, 1, 2.0), triplet(2, 1, -1.0)];
        SparseSymmetric::from_triplets(3, &entries).expect("well formed")
    }

    #[test]
    fn addends_go_to_entries_that_are_there() {
        let sum = path().plus([triplet(0, 1, 0.5), triplet(2, 2, 3.0)]).expect("in the pattern");
        assert_eq!(sum.multiply(&[1.0, 1.0, 1.0]), Ok(vec![1.5, 0.5, 2.0]));
        assert!(path().plus([triplet(2, 0, 1.0)]).is_err());
        assert!(path().plus([triplet(3, 3, 1.0)]).is_err());
    }

    #[test]
    fn held_unknowns_move_to_the_other_side() {
        let (matrix, moved) = path().leading(2, &[5.0]).expect("three");
        assert_eq!((matrix.order(), moved), (2, vec![0.0, 5.0]));
        assert_eq!(matrix.multiply(&[1.0, 1.0]), Ok(vec![1.0, 1.0]));
        assert!(path().leading(2, &[]).is_err());
    }
}
