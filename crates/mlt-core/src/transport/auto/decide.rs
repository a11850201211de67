//! Which parts of path space are sampled by which estimator.

/// What is known of one part of path space, in a unit of error × work: how much error, squared and over work, an estimator
/// leaves that does nothing else.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Costs {
    /// Of each independent method: error of one sample a pixel; infinite if it does not sample this part. All parts share
    /// its samples.
    pub(super) independent: Vec<f64>,
    /// Of chains: error × work.
    pub(super) chains: f64,
}

/// How a render's work is shared out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Decision {
    /// The independent method; `None`: chains alone.
    pub(super) independent: Option<usize>,
    /// Whether each part is left to chains.
    pub(super) in_chains: Vec<bool>,
    /// Share of the work that chains get.
    pub(super) chain_share: f64,
    /// Error × work that is to be expected.
    pub(super) product: f64,
}

/// A mixture is to be better than every single method by this factor, since it is chosen by noisy figures.
const MIXTURE_GAIN: f64 = 0.6;

/// Finds the cheapest of all ways to give each part to one independent method or to chains.
///
/// With work W_0 for independent samples, each of which takes `work[m]` and covers all its parts E, and W_i for chains in
/// part i ∉ E, the error is
///
/// work[m] Σ_E A_i / W_0 + Σ_{i ∉ E} B_i / W_i,   least at W_0 ∝ √(work[m] Σ_E A_i), W_i ∝ √B_i:
///
/// error × work = (√(work[m] Σ_E A_i) + Σ_{i ∉ E} √B_i)².
///
/// It is concave in the two sums, so the best E is a run of the parts sorted by A_i / √B_i.
pub(super) fn decide(work: &[f64], parts: &[Costs]) -> Decision {
    let chains = |i: usize| parts[i].chains.sqrt();
    let all: f64 = (0..parts.len()).map(chains).sum();
    let alone =
        Decision { independent: None, in_chains: vec![true; parts.len()], chain_share: 1.0, product: all * all };
    let nothing = Decision { product: f64::INFINITY, ..alone.clone() };
    let mut best_single = alone;
    let mut best_mixture: Option<Decision> = None;
    for (m, &work) in work.iter().enumerate() {
        let mut order: Vec<usize> = (0..parts.len()).collect();
        let ratio = |i: usize| parts[i].independent[m] / chains(i).max(f64::MIN_POSITIVE);
        order.sort_by(|&i, &j| ratio(i).total_cmp(&ratio(j)));
        for easy in 1..=parts.len() {
            let sampled = (work * order[..easy].iter().map(|&i| parts[i].independent[m]).sum::<f64>()).sqrt();
            let chained: f64 = order[easy..].iter().map(|&i| chains(i)).sum();
            let mut in_chains = vec![true; parts.len()];
            order[..easy].iter().for_each(|&i| in_chains[i] = false);
            let chain_share = if chained > 0.0 { chained / (sampled + chained) } else { 0.0 };
            let product = (sampled + chained).powi(2);
            // Chains with help for nothing but what they do not sample at all, or what is dark, are a single method.
            let helps = |&i: &usize| parts[i].chains > 0.0 && parts[i].chains.is_finite();
            let single = easy == parts.len() || !order[..easy].iter().any(helps);
            let best = if single { &mut best_single } else { best_mixture.get_or_insert(nothing.clone()) };
            if product < best.product {
                *best = Decision { independent: Some(m), in_chains, chain_share, product };
            }
        }
    }
    match best_mixture {
        Some(mixture) if mixture.product < MIXTURE_GAIN * best_single.product => mixture,
        _ => best_single,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(first: f64, second: f64, chains: f64) -> Costs {
        Costs { independent: vec![first, second], chains }
    }

    #[test]
    fn a_single_method_that_is_best_everywhere_is_taken_alone() {
        let easy = decide(&[2.0, 8.0], &[part(1.0, 0.5, 30.0), part(2.0, 1.0, 50.0)]);
        assert_eq!((easy.independent, easy.in_chains, easy.chain_share), (Some(0), vec![false; 2], 0.0));
        assert!((easy.product / 6.0 - 1.0).abs() < 1e-12);
        let second = decide(&[2.0, 8.0], &[part(100.0, 0.5, 30.0), part(2.0, 1.0, 50.0)]);
        assert_eq!((second.independent, second.chain_share), (Some(1), 0.0));
        let hard = decide(&[2.0, 8.0], &[part(1e3, 1e3, 3.0), part(1e4, 1e6, 5.0)]);
        assert_eq!((hard.independent, hard.in_chains, hard.chain_share), (None, vec![true; 2], 1.0));
    }

    #[test]
    fn a_part_that_is_hard_to_sample_is_left_to_chains() {
        let mixed = decide(&[1.0, 4.0], &[part(1.0, 1.0, 400.0), part(1e5, 1e4, 9.0), part(0.0, 0.0, 0.0)]);
        assert_eq!((mixed.independent, mixed.in_chains), (Some(0), vec![false, true, false]));
        assert!((mixed.product - 16.0).abs() < 1e-12 && (mixed.chain_share - 0.75).abs() < 1e-12);
    }

    #[test]
    fn a_method_that_does_not_sample_a_part_is_taken_for_others() {
        let short = decide(&[1.0, 4.0], &[part(1.0, 1.0, 400.0), part(f64::INFINITY, 9.0, 9.0)]);
        assert_eq!((short.independent, short.in_chains, short.product), (Some(0), vec![false, true], 16.0));
    }

    /// A mixture is not taken for a few per cent, also where chains need help with what they do not sample.
    #[test]
    fn chains_with_help_are_a_single_method() {
        let lamp = part(0.01, 0.01, f64::INFINITY);
        let hard = [part(15.0, 99.0, 16.0), part(1e5, 1e4, 36.0)];
        let close = decide(&[1.0, 4.0], &[vec![lamp.clone()], hard.to_vec()].concat());
        assert_eq!((close.independent, close.in_chains), (Some(0), vec![false, true, true]));
        assert!((close.product / 10.1f64.powi(2) - 1.0).abs() < 1e-12);
        let dark = decide(&[1.0, 4.0], &[vec![part(0.0, 0.0, 0.0), lamp.clone()], hard.to_vec()].concat());
        assert_eq!((dark.product, &dark.in_chains[1..]), (close.product, &[false, true, true][..]));
        let far = decide(&[1.0, 4.0], &[lamp, part(1.0, 99.0, 16.0), part(1e5, 1e4, 9.0)]);
        assert_eq!((far.independent, far.in_chains), (Some(0), vec![false, false, true]));
    }

    #[test]
    fn no_subset_is_better() {
        let numbers = |seed: u32| (0..6).map(move |i| f64::from((seed * 7919 + i * 104_729) % 1000 + 1));
        for seed in 1..200 {
            let parts: Vec<_> = (numbers(seed).zip(numbers(3 * seed)).zip(numbers(5 * seed)))
                .map(|((a, b), c)| part(a, b, c * 30.0))
                .collect();
            let work = [1.5, 4.0];
            let product = |m: usize, set: u32| {
                let of = |inside: bool| parts.iter().enumerate().filter(move |(i, _)| (set >> i & 1 == 1) == inside);
                let sampled: f64 = of(true).map(|(_, p)| p.independent[m]).sum();
                let chained: f64 = of(false).map(|(_, p)| p.chains.sqrt()).sum();
                ((work[m] * sampled).sqrt() + chained).powi(2)
            };
            let best = (0..64).flat_map(|set| [product(0, set), product(1, set)]).fold(f64::INFINITY, f64::min);
            let single = product(0, 63).min(product(1, 63)).min(product(0, 0));
            let expected = if best < MIXTURE_GAIN * single { best } else { single };
            assert!((decide(&work, &parts).product / expected - 1.0).abs() < 1e-9);
        }
    }
}
