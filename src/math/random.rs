//! Seeded random streams.
//!
//! Every restart, joint and leg draws from a stream of its own, so results do
//! not depend on who runs first.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::lanes::WIDTH;

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
/// are drawn in advance: within a lane's loop over rounds its state stays in a
/// register, and the loop over lanes is one the compiler makes wide.
#[derive(Clone, Debug)]
pub struct RandomLanes {
    state: [[u64; WIDTH]; 4],
    drawn: [[u64; WIDTH]; Self::ROUNDS],
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
        Self { state, drawn: [[0; WIDTH]; Self::ROUNDS], next: Self::ROUNDS }
    }

    /// 64 random bits per lane.
    #[inline(always)]
    pub fn bits(&mut self) -> [u64; WIDTH] {
        if self.next == Self::ROUNDS {
            self.draw();
        }
        let bits = self.drawn[self.next];
        self.next += 1;
        bits
    }

    #[inline(always)]
    fn draw(&mut self) {
        let [w0, w1, w2, w3] = &mut self.state;
        for l in 0..WIDTH {
            let (mut s0, mut s1, mut s2, mut s3) = (w0[l], w1[l], w2[l], w3[l]);
            for round in &mut self.drawn {
                round[l] = s0.wrapping_add(s3).rotate_left(23).wrapping_add(s0);
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
        self.next = 0;
    }

    /// Two numbers uniform in [0, 1) per lane, multiples of 2^-32: the upper
    /// and the lower half of its 64 bits.
    #[inline(always)]
    pub fn pair(&mut self) -> [[f64; WIDTH]; 2] {
        const SCALE: f64 = 1.0 / (1u64 << 32) as f64;
        let bits = self.bits();
        let mut pair = [[0.0; WIDTH]; 2];
        for l in 0..WIDTH {
            pair[0][l] = f64::from((bits[l] >> 32) as u32) * SCALE;
            pair[1][l] = f64::from(bits[l] as u32) * SCALE;
        }
        pair
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
            let expected: Vec<u64> = single.iter_mut().map(|s| s.next_u64()).collect();
            assert_eq!(lanes.bits().to_vec(), expected);
        }
    }

    #[test]
    fn pairs_fill_the_unit_interval_evenly() {
        let mut lanes = RandomLanes::new(1, 2);
        let mut counts = [[0u32; 10]; 2];
        for _ in 0..12_500 {
            for (counts, half) in counts.iter_mut().zip(lanes.pair()) {
                half.iter().for_each(|x| counts[(x * 10.0) as usize] += 1);
            }
        }
        let even = |&count: &u32| (9_600..10_400).contains(&count);
        assert!(counts.iter().flatten().all(even), "{counts:?}");
    }
}
