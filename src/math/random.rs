//! Seeded random streams.
//!
//! Every restart, joint and leg draws from a stream of its own, so results do
//! not depend on who runs first.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::lanes::{Lanes, WIDTH};

/// A stream of random numbers: xoshiro256++, seeded through SplitMix64.
#[derive(Clone, Debug)]
pub struct RandomStream(Xoshiro256PlusPlus);

impl RandomStream {
    /// Stream `stream` of `seed`; different pairs give unrelated streams.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(derive_seed(seed, stream)))
    }

    /// Uniform in [0, 1): the upper 53 bits, as exact multiples of 2^-53.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * SCALE
    }

    /// Uniform in [`lower`, `upper`).
    #[inline]
    pub fn uniform(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }
}

/// Eight streams side by side, for loops that draw for eight numbers at a time.
///
/// xoshiro256++ like [`RandomStream`], one generator per lane. Several rounds
/// are drawn in advance, lane by lane: state stays in registers meanwhile, and
/// the loop over lanes is one that the compiler makes wide.
#[derive(Clone, Debug)]
pub struct RandomLanes {
    state: [[u64; WIDTH]; 4],
    drawn: [[Lanes; 2]; Self::ROUNDS],
    /// The next of `drawn` to hand out.
    next: usize,
}

impl RandomLanes {
    const ROUNDS: usize = 8;

    /// Stream `stream` of `seed`: word `w` of lane `l` starts as
    /// `derive_seed(derive_seed(seed, stream), 4 l + w)`.
    pub fn new(seed: u64, stream: u64) -> Self {
        let seed = derive_seed(seed, stream);
        let word = |w: usize, l: usize| derive_seed(seed, (4 * l + w) as u64);
        let state = std::array::from_fn(|w| std::array::from_fn(|l| word(w, l)));
        Self { state, drawn: [[Lanes::ZERO; 2]; Self::ROUNDS], next: Self::ROUNDS }
    }

    /// Two numbers uniform in [0, 1) per lane, multiples of 2^-32: the upper
    /// and the lower half of its 64 bits.
    #[inline(always)]
    pub fn pair(&mut self) -> &[Lanes; 2] {
        if self.next == Self::ROUNDS {
            self.draw();
            self.next = 0;
        }
        self.next += 1;
        &self.drawn[self.next - 1]
    }

    #[inline(always)]
    fn draw(&mut self) {
        const SCALE: f64 = 1.0 / (1u64 << 32) as f64;
        let [w0, w1, w2, w3] = &mut self.state;
        for l in 0..WIDTH {
            let (mut s0, mut s1, mut s2, mut s3) = (w0[l], w1[l], w2[l], w3[l]);
            for [upper, lower] in &mut self.drawn {
                let bits = s0.wrapping_add(s3).rotate_left(23).wrapping_add(s0);
                upper.0[l] = f64::from((bits >> 32) as u32) * SCALE;
                lower.0[l] = f64::from(bits as u32) * SCALE;
                let t = s1 << 17;
                s2 ^= s0;
                s3 ^= s1;
                s1 ^= s2;
                s0 ^= s3;
                s2 ^= t;
                s3 = s3.rotate_left(45);
            }
            (w0[l], w1[l], w2[l], w3[l]) = (s0, s1, s2, s3);
        }
    }
}

/// The seed of part `stream` of a computation seeded with `seed`.
///
/// The SplitMix64 finaliser (Steele, Lea and Flood, 2014,
/// doi:10.1145/2660193.2660195) over the pair.
pub fn derive_seed(seed: u64, stream: u64) -> u64 {
    let mut z = seed.wrapping_add(stream.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_repeat_and_differ() {
        let draw = |seed, stream| {
            let mut random = RandomStream::new(seed, stream);
            [random.unit(), random.unit(), random.unit()]
        };
        assert_eq!(draw(7, 0), draw(7, 0));
        assert_ne!(draw(7, 0), draw(7, 1));
        assert_ne!(draw(7, 0), draw(8, 0));
    }

    #[test]
    fn draws_fill_the_unit_interval_evenly() {
        let mut random = RandomStream::new(1, 2);
        let mut counts = [0u32; 10];
        for _ in 0..100_000 {
            counts[(random.unit() * 10.0) as usize] += 1;
        }
        assert!(counts.iter().all(|&count| (9_600..10_400).contains(&count)), "{counts:?}");
    }

    /// Lane by lane the generator of the crate that [`RandomStream`] uses.
    #[test]
    fn lanes_are_streams_of_their_own() {
        const TWO_TO_32: f64 = 4_294_967_296.0;
        let mut lanes = RandomLanes::new(7, 3);
        let seed = derive_seed(7, 3);
        let mut single: Vec<Xoshiro256PlusPlus> = (0..WIDTH as u64)
            .map(|l| {
                let words = (0..4).flat_map(|w| derive_seed(seed, 4 * l + w).to_le_bytes());
                let bytes: Vec<u8> = words.collect();
                Xoshiro256PlusPlus::from_seed(bytes.try_into().unwrap())
            })
            .collect();
        for _ in 0..1000 {
            let [upper, lower] = lanes.pair().map(|half| half.0.map(|x| (x * TWO_TO_32) as u64));
            for (stream, halves) in single.iter_mut().zip(upper.into_iter().zip(lower)) {
                let bits = stream.next_u64();
                assert_eq!(halves, (bits >> 32, bits & 0xffff_ffff));
            }
        }
    }

    #[test]
    fn pairs_fill_the_unit_interval_evenly() {
        let mut lanes = RandomLanes::new(1, 2);
        let mut counts = [[0u32; 10]; 2];
        for _ in 0..12_500 {
            for (counts, half) in counts.iter_mut().zip(lanes.pair()) {
                half.0.iter().for_each(|x| counts[(x * 10.0) as usize] += 1);
            }
        }
        let even = |&count: &u32| (9_600..10_400).contains(&count);
        assert!(counts.iter().flatten().all(even), "{counts:?}");
    }
}
