//! Eight numbers at once: with AVX2 where the machine has it, otherwise in plain code.
//!
//! Both round every operation alike (no fused multiplication), so that results do not depend on the machine.

use std::ops::{Add, Div, Mul, Sub};

use glam::Vec3;

use super::stack::{ROOM, Room};

/// How many numbers there are.
pub const LANES: usize = 8;

/// Eight numbers. Comparisons give one bit for each, which is 0 for NaN.
pub trait Eight:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proof that the machine has the instructions.
    type Machine: Copy;

    /// From numbers in memory.
    fn load(machine: Self::Machine, numbers: &[f32; LANES]) -> Self;
    /// All the same.
    fn splat(machine: Self::Machine, number: f32) -> Self;
    /// The numbers.
    fn to_array(self) -> [f32; LANES];
    /// The lesser of each pair; `other` if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The greater of each pair; `other` if one is NaN.
    fn max(self, other: Self) -> Self;
    /// Without signs.
    fn abs(self) -> Self;
    /// Where `self < other`.
    fn below(self, other: Self) -> u32;
    /// Where `self <= other`.
    fn at_most(self, other: Self) -> u32;
    /// Where they are equal.
    fn equal(self, other: Self) -> u32;
    /// Which of eight integers are one of two.
    fn among(machine: Self::Machine, integers: &[u32; LANES], two: [u32; 2]) -> u32;
}

/// Three coordinates of eight points.
pub type Points<E> = [E; 3];

/// Eight times the same point.
#[inline(always)]
pub fn same<E: Eight>(machine: E::Machine, point: Vec3) -> Points<E> {
    [E::splat(machine, point.x), E::splat(machine, point.y), E::splat(machine, point.z)]
}

/// The difference.
#[inline(always)]
pub fn minus<E: Eight>(p: &Points<E>, q: &Points<E>) -> Points<E> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// The vector product.
#[inline(always)]
pub fn cross<E: Eight>(p: &Points<E>, q: &Points<E>) -> Points<E> {
    [p[1] * q[2] - q[1] * p[2], p[2] * q[0] - q[2] * p[0], p[0] * q[1] - q[0] * p[1]]
}

/// The scalar product.
#[inline(always)]
pub fn dot<E: Eight>(p: &Points<E>, q: &Points<E>) -> E {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// Without signs.
#[inline(always)]
pub fn abs<E: Eight>(p: &Points<E>) -> Points<E> {
    [p[0].abs(), p[1].abs(), p[2].abs()]
}

/// The greater coordinates.
#[inline(always)]
pub fn max<E: Eight>(p: &Points<E>, q: &Points<E>) -> Points<E> {
    [p[0].max(q[0]), p[1].max(q[1]), p[2].max(q[2])]
}

/// What is computed eight numbers at once.
pub trait Task {
    /// What comes out.
    type Output;

    /// Computes it. This, and all that it calls, has to be inlined to have the machine's instructions.
    fn run<E: Eight>(self, at: At<'_, E>) -> Self::Output;

    /// The same in plain code, of which there is much: what of a task is not computed eight numbers at once is better not in it,
    /// so that there is one for many tasks.
    #[inline(always)]
    fn run_plainly(self, room: &Room) -> Self::Output
    where
        Self: Sized,
    {
        plainly(self, room)
    }
}

/// What a task is computed by, and where it keeps what it has still to do.
pub type At<'r, E> = (<E as Eight>::Machine, &'r Room);

/// What a machine can do.
#[derive(Clone, Copy, Debug)]
pub enum Machine {
    /// Anything.
    Any,
    /// x86-64 with AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
}

impl Machine {
    /// This one.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(instructions) = pulp::x86::V3::try_new() {
            return Self::Avx2(instructions);
        }
        Self::Any
    }

    /// Computes something.
    #[inline(always)]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        ROOM.with(|room| match self {
            Self::Any => task.run_plainly(room),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(machine) => machine.vectorize(avx2::Call { at: (machine, room), task }),
        })
    }
}

/// Out of the way of the machine's instructions: what is inlined needs room and registers even where it is not run.
#[inline(never)]
pub fn plainly<T: Task>(task: T, room: &Room) -> T::Output {
    task.run::<Plain>(((), room))
}

/// Eight numbers in plain code.
#[derive(Clone, Copy)]
pub struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..LANES).map(|i| u32::from(f(self.0[i], other.0[i])) << i).sum()
    }
}

macro_rules! operators {
    ($type:ty: $($trait:ident $method:ident $with:expr;)*) => { $(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                ($with)(self, other)
            }
        }
    )* };
}

operators! {
    Plain:
    Add add |a: Plain, b| a.zip(b, f32::add);
    Sub sub |a: Plain, b| a.zip(b, f32::sub);
    Mul mul |a: Plain, b| a.zip(b, f32::mul);
    Div div |a: Plain, b| a.zip(b, f32::div);
}

impl Eight for Plain {
    type Machine = ();

    #[inline(always)]
    fn load((): (), numbers: &[f32; LANES]) -> Self {
        Self(*numbers)
    }
    #[inline(always)]
    fn splat((): (), number: f32) -> Self {
        Self([number; LANES])
    }
    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        self.0
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        self.bits(other, |a, b| a == b)
    }
    #[inline(always)]
    fn among((): (), integers: &[u32; LANES], two: [u32; 2]) -> u32 {
        (0..LANES).map(|i| u32::from(two.contains(&integers[i])) << i).sum()
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m256, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ};
    use std::ops::{Add, Div, Mul, Sub};

    use pulp::NullaryFnOnce;
    use pulp::x86::V3;

    use super::{At, Eight, LANES, Task};

    /// A task that a machine with AVX2 is to run.
    pub struct Call<'r, T> {
        pub at: At<'r, Register>,
        pub task: T,
    }

    impl<T: Task> NullaryFnOnce for Call<'_, T> {
        type Output = T::Output;

        #[inline(always)]
        fn call(self) -> T::Output {
            self.task.run::<Register>(self.at)
        }
    }

    /// Eight numbers in a register.
    #[derive(Clone, Copy)]
    pub struct Register(V3, __m256);

    operators! {
        Register:
        Add add |a: Register, b: Register| Register(a.0, a.0.avx._mm256_add_ps(a.1, b.1));
        Sub sub |a: Register, b: Register| Register(a.0, a.0.avx._mm256_sub_ps(a.1, b.1));
        Mul mul |a: Register, b: Register| Register(a.0, a.0.avx._mm256_mul_ps(a.1, b.1));
        Div div |a: Register, b: Register| Register(a.0, a.0.avx._mm256_div_ps(a.1, b.1));
    }

    impl Register {
        #[inline(always)]
        fn bits<const OPERATION: i32>(self, other: Self) -> u32 {
            let avx = self.0.avx;
            let mask = avx._mm256_cmp_ps::<OPERATION>(self.1, other.1);
            avx._mm256_movemask_ps(mask) as u32
        }
    }

    impl Eight for Register {
        type Machine = V3;

        #[inline(always)]
        fn load(machine: V3, numbers: &[f32; LANES]) -> Self {
            Self(machine, pulp::cast(*numbers))
        }
        #[inline(always)]
        fn splat(machine: V3, number: f32) -> Self {
            Self(machine, machine.avx._mm256_set1_ps(number))
        }
        #[inline(always)]
        fn to_array(self) -> [f32; LANES] {
            pulp::cast(self.1)
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(self.0, self.0.avx._mm256_min_ps(self.1, other.1))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(self.0, self.0.avx._mm256_max_ps(self.1, other.1))
        }
        #[inline(always)]
        fn abs(self) -> Self {
            let sign = self.0.avx._mm256_set1_ps(-0.0);
            Self(self.0, self.0.avx._mm256_andnot_ps(sign, self.1))
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            self.bits::<_CMP_LT_OQ>(other)
        }
        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            self.bits::<_CMP_LE_OQ>(other)
        }
        #[inline(always)]
        fn equal(self, other: Self) -> u32 {
            self.bits::<_CMP_EQ_OQ>(other)
        }
        #[inline(always)]
        fn among(machine: V3, integers: &[u32; LANES], [a, b]: [u32; 2]) -> u32 {
            let (avx, avx2) = (machine.avx, machine.avx2);
            let all = pulp::cast(*integers);
            let is_a = avx2._mm256_cmpeq_epi32(all, avx._mm256_set1_epi32(a as i32));
            let is_b = avx2._mm256_cmpeq_epi32(all, avx._mm256_set1_epi32(b as i32));
            avx._mm256_movemask_ps(pulp::cast(avx2._mm256_or_si256(is_a, is_b))) as u32
        }
    }
}
