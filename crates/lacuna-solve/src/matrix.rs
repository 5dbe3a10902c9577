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

    /// The same matrix with `addends` on its diagonal, one a column; the pattern stays.
    ///
    /// # Errors
    /// [`SolveError::Malformed`] unless there is one addend a column.
    pub fn plus_diagonal(&self, addends: &[f64]) -> Result<Self, SolveError> {
        if addends.len() != self.order() {
            return Err(malformed("the diagonal's length is not the matrix's order"));
        }
        let mut sum = self.clone();
        for (column, addend) in addends.iter().enumerate() {
            // The first entry of a column is the one on the diagonal.
            sum.values[self.starts[column] as usize] += addend;
        }
        Ok(sum)
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
