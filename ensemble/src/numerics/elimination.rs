//! Systems of linear equations in lanes, of the size used in [`conduction`](crate::conduction): eliminated once, solved for several
//! right-hand sides.

use crate::lanes::{Lanes, multiply_add};
use chamber::real::Real;
use core::hint::black_box;

/// Number of equations.
pub const SIZE: usize = 6;

/// The factors of a matrix, without pivoting: its diagonal must be large.
pub struct Factors {
    /// The matrix to be factorised next.
    pub next: [[Lanes; SIZE]; SIZE],
    /// The upper factor above the diagonal, the negative lower factor below it.
    matrix: [[Lanes; SIZE]; SIZE],
    /// Reciprocals of the diagonal.
    per_pivot: [Lanes; SIZE],
}

impl Factors {
    /// Without a matrix.
    pub const NONE: Self =
        Self { next: [[Lanes::ZERO; SIZE]; SIZE], matrix: [[Lanes::ZERO; SIZE]; SIZE], per_pivot: [Lanes::ONE; SIZE] };

    /// Factorises the next matrix, in place, in lanes where `anew` is positive.
    #[inline(always)]
    pub fn take(&mut self, anew: Lanes) {
        let matrix = &mut self.next;
        for pivot in 0..SIZE {
            let per_pivot = matrix[pivot][pivot].recip();
            self.per_pivot[pivot] = anew.where_positive(per_pivot, self.per_pivot[pivot]);
            for row in pivot + 1..SIZE {
                let factor = -(matrix[row][pivot] * per_pivot);
                matrix[row][pivot] = factor;
                for column in pivot + 1..SIZE {
                    matrix[row][column] = multiply_add::<true>(factor, matrix[pivot][column], matrix[row][column]);
                }
            }
        }
        for row in 0..black_box(SIZE) {
            for column in 0..SIZE {
                self.matrix[row][column] = anew.where_positive(matrix[row][column], self.matrix[row][column]);
            }
        }
    }

    /// The solution for a right-hand side, which is overwritten. Unrolled by hand, as the compiler does not unroll such loops.
    #[inline(always)]
    pub fn solve(&self, right: &mut [Lanes; SIZE]) -> [Lanes; SIZE] {
        let Self { matrix, per_pivot, .. } = self;
        macro_rules! eliminate {
            ($pivot:literal; $($row:literal)*) => {
                $(right[$row] = multiply_add::<true>(matrix[$row][$pivot], right[$pivot], right[$row]);)*
            };
        }
        eliminate!(0; 1 2 3 4 5);
        eliminate!(1; 2 3 4 5);
        eliminate!(2; 3 4 5);
        eliminate!(3; 4 5);
        eliminate!(4; 5);
        let mut solution = [Lanes::ZERO; SIZE];
        macro_rules! substitute {
            ($row:literal; $($column:literal)*) => {
                solution[$row] = right[$row];
                $(solution[$row] -= matrix[$row][$column] * solution[$column];)*
                solution[$row] = solution[$row] * per_pivot[$row];
            };
        }
        substitute!(5;);
        substitute!(4; 5);
        substitute!(3; 5 4);
        substitute!(2; 5 4 3);
        substitute!(1; 5 4 3 2);
        substitute!(0; 5 4 3 2 1);
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_the_equations_and_a_matrix_is_taken_only_where_it_is_asked_for() {
        let entry = |row: usize, column: usize| {
            let small = ((3 + 7 * row + 5 * column) % 11) as f64 / 11.0;
            if row == column { 4.0 + small } else { small }
        };
        let of = |scale: f64| core::array::from_fn(|i| core::array::from_fn(|j| Lanes::from(entry(i, j) * scale)));
        let mut factors = Factors { next: of(1.0), ..Factors::NONE };
        factors.take(Lanes::ONE);
        factors.next = of(2.0);
        factors.take(Lanes::from_fn(|lane| (lane % 2) as f64));
        let expected: [f64; SIZE] = core::array::from_fn(|k| 1.0 - 0.3 * k as f64);
        let mut right =
            core::array::from_fn(|i| Lanes::from((0..SIZE).map(|j| entry(i, j) * expected[j]).sum::<f64>()));
        let found = factors.solve(&mut right);
        for lane in 0..4 {
            let scale = if lane % 2 == 0 { 1.0 } else { 0.5 };
            for k in 0..SIZE {
                assert!((found[k][lane] - scale * expected[k]).abs() < 1e-14, "{lane} {k}");
            }
        }
    }
}
