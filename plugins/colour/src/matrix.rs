//! Matrices of three rows, at compile time too.

/// A matrix, row by row.
pub type Matrix = [[f64; 3]; 3];

/// The scalar product.
pub const fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

const fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The product of a matrix and a vector.
#[inline]
pub const fn times(m: Matrix, v: [f64; 3]) -> [f64; 3] {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

const fn transposed([a, b, c]: Matrix) -> Matrix {
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}

/// The product of two matrices.
pub const fn product(a: Matrix, b: Matrix) -> Matrix {
    let columns = transposed(b);
    transposed([times(a, columns[0]), times(a, columns[1]), times(a, columns[2])])
}

/// The inverse: the cross products of the rows are the columns, over the determinant.
pub const fn inverse([a, b, c]: Matrix) -> Matrix {
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let determinant = dot(a, bc);
    let mut rows = [[0.0; 3]; 3];
    let mut k = 0;
    while k < 3 {
        rows[k] = [bc[k] / determinant, ca[k] / determinant, ab[k] / determinant];
        k += 1;
    }
    rows
}

/// XYZ of red, green and blue of these chromaticities, in the amounts that make the white of D65.
pub const fn xyz_from_primaries([[rx, ry], [gx, gy], [bx, by]]: [[f64; 2]; 3]) -> Matrix {
    let columns = [[rx, gx, bx], [ry, gy, by], [1.0 - rx - ry, 1.0 - gx - gy, 1.0 - bx - by]];
    let amounts = times(inverse(columns), crate::observer::D65_XYZ);
    let mut matrix = columns;
    let mut k = 0;
    while k < 3 {
        let mut row = 0;
        while row < 3 {
            matrix[row][k] *= amounts[k];
            row += 1;
        }
        k += 1;
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let m = [[2.0, -1.0, 0.5], [0.0, 3.0, 1.0], [4.0, 0.25, -2.0]];
        let one = product(m, inverse(m));
        for (i, row) in one.iter().enumerate() {
            assert!(row.iter().enumerate().all(|(k, x)| (x - if i == k { 1.0 } else { 0.0 }).abs() < 1e-15), "{one:?}");
        }
    }
}
