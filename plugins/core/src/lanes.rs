//! Vectors of several rays side by side: one arithmetic operation for all of them.

use glam::DVec3;
use std::ops::{Add, Mul, Sub};
use wide::f64x8;

/// Rays that are followed side by side.
pub const LANES: usize = 8;

/// A number of each ray; or a yes or no of each, all bits set or none.
pub type Lanes = f64x8;

/// Nothing but no.
pub fn none() -> Lanes {
    Lanes::splat(0.0)
}

/// Yes of the first `count` rays.
pub fn first(count: usize) -> Lanes {
    let numbers = Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| i as f64));
    numbers.simd_lt(Lanes::splat(count as f64))
}

/// Yes of the rays whose bits are set.
pub fn of_bits(bits: u32) -> Lanes {
    let numbers = Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| f64::from(bits >> i & 1)));
    numbers.simd_eq(Lanes::splat(1.0))
}

/// The numbers of the bits that are set, from the lowest.
pub fn set_bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = bits.trailing_zeros() as usize;
        (i < LANES).then(|| {
            bits &= bits - 1;
            i
        })
    })
}

/// A vector of each ray.
#[derive(Clone, Copy, Debug)]
pub struct Vectors {
    /// First coordinates.
    pub x: Lanes,
    /// Second coordinates.
    pub y: Lanes,
    /// Third coordinates.
    pub z: Lanes,
}

impl Vectors {
    /// The same vector of all rays.
    #[inline(always)]
    pub fn all(v: DVec3) -> Self {
        Self { x: Lanes::splat(v.x), y: Lanes::splat(v.y), z: Lanes::splat(v.z) }
    }

    /// Vector number i of ray number i.
    #[inline(always)]
    pub fn of(v: [DVec3; LANES]) -> Self {
        Self { x: Lanes::from(v.map(|v| v.x)), y: Lanes::from(v.map(|v| v.y)), z: Lanes::from(v.map(|v| v.z)) }
    }

    /// The coordinates as arrays.
    #[inline(always)]
    pub fn to_arrays(self) -> [[f64; LANES]; 3] {
        [self.x.to_array(), self.y.to_array(), self.z.to_array()]
    }

    /// The vector of ray number `i`.
    #[inline]
    pub fn lane(self, i: usize) -> DVec3 {
        let [x, y, z] = self.to_arrays();
        DVec3::new(x[i], y[i], z[i])
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, o: Self) -> Lanes {
        self.x.mul_add(o.x, self.y.mul_add(o.y, self.z * o.z))
    }

    /// Vector products.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    /// Squares of the lengths.
    #[inline(always)]
    pub fn length_squared(self) -> Lanes {
        self.dot(self)
    }

    /// `self + o s`
    #[inline(always)]
    pub fn plus(self, o: Self, s: Lanes) -> Self {
        Self { x: o.x.mul_add(s, self.x), y: o.y.mul_add(s, self.y), z: o.z.mul_add(s, self.z) }
    }

    /// Each divided by its number.
    #[inline(always)]
    pub fn over(self, s: Lanes) -> Self {
        Self { x: self.x / s, y: self.y / s, z: self.z / s }
    }

    /// The largest of the absolute coordinates.
    #[inline(always)]
    pub fn largest(self) -> Lanes {
        self.x.abs().fast_max(self.y.abs()).fast_max(self.z.abs())
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(self, o: Self, which: Lanes) -> Self {
        Self { x: pick(which, self.x, o.x), y: pick(which, self.y, o.y), z: pick(which, self.z, o.z) }
    }
}

/// Of the rays in `which` the numbers `yes`, of the others `no`.
#[inline(always)]
pub fn pick(which: Lanes, yes: Lanes, no: Lanes) -> Lanes {
    which.select(yes, no)
}

impl Add for Vectors {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Vectors {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Mul<Lanes> for Vectors {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: Lanes) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
