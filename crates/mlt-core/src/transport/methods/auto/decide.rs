//! Which parts of path space are sampled by which estimator.

use super::constants::{LEAST_CHAINS, MIXTURE_GAIN, MOST_WORK};

/// Knowledge of one part of path space, as error × work: an estimator that samples this part alone with the work W leaves the
/// squared error (error × work)/W.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Costs {
    /// Of each independent method: error of one sample a pixel; infinite if it does not sample this part. All parts share
    /// its samples.
    pub(super) independent: Vec<f64>,
    /// Of chains: error × work.
    pub(super) chains: f64,
    /// Upper bound of that: chains get their share by this, so that a rare event does less harm.
    pub(super) at_most: f64,
    /// Whether an independent method was to meet this part's light rarely, and its noise is not known.
    pub(super) rare: bool,
}

/// How a round's work is shared out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Decision {
    /// The independent method, and its samples of each pixel; `None`: chains alone.
    pub(super) independent: Option<(usize, f64)>,
    /// Whether each part is left to chains.
    pub(super) in_chains: Vec<bool>,
    /// Work of the samples of a pixel.
    pub(super) sample_work: f64,
    /// Error that they leave.
    pub(super) sample_error: f64,
    /// Work of chains, for each pixel.
    pub(super) chain_work: f64,
    /// Error × work of chains, as it is to be expected and at most.
    pub(super) chain_products: [f64; 2],
}

impl Decision {
    /// Work for each pixel.
    pub(super) fn work(&self) -> f64 {
        self.sample_work + self.chain_work
    }

    /// Share of the work that chains get.
    pub(super) fn chain_share(&self) -> f64 {
        self.chain_work / self.work()
    }

    /// Error × work that is to be expected.
    pub(super) fn product(&self) -> f64 {
        self.with_chains(self.chain_products[0])
    }

    /// The same at most.
    fn at_most(&self) -> f64 {
        self.with_chains(self.chain_products[1])
    }

    fn with_chains(&self, product: f64) -> f64 {
        let of_chains = if product > 0.0 { product / self.chain_work } else { 0.0 };
        (self.sample_error + of_chains) * self.work()
    }
}

/// The decisions that are open to a pilot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// The best method alone. Chains with help for nothing but what they do not sample at all, or what is dark, are one.
    pub(super) single: Decision,
    /// The best mixture, if it is better.
    pub(super) mixture: Option<Decision>,
}

impl Choice {
    /// The best plan.
    pub(super) fn best(&self) -> &Decision {
        self.mixture.as_ref().unwrap_or(&self.single)
    }
}

/// Finds the best of all ways to give each part to one independent method or to chains, with `budget` for a round's work of
/// each pixel and `work[m]` for a sample.
///
/// With n samples of each pixel for the parts E, n a power of two, and chains for all other parts,
///
/// error = Σ_E A_i / n + (Σ_{i ∉ E} √B_i)² / (budget − n work[m]).
///
/// With any n, error × work were (√(work[m] Σ_E A_i) + Σ_{i ∉ E} √B_i)² at best. That is concave in the two sums, so the
/// best E is a run of the parts sorted by A_i / √B_i.
///
/// Of ways that promise the same, the one with fewer rays is taken.
pub(super) fn decide(budget: f64, work: &[f64], parts: &[Costs]) -> Choice {
    let mut single = chains_alone(budget, parts);
    let mut mixture: Option<Decision> = None;
    for (m, &work) in work.iter().enumerate() {
        for sampled in easiest(m, parts) {
            let numbers = (0..).map(|k| libm::exp2(f64::from(k))).take_while(|n| n * work <= 2.0 * budget);
            let ways = numbers.filter_map(|n| mixed(budget, (m, n, work), &sampled, parts));
            let Some(decision) = ways.min_by(|a, b| a.at_most().total_cmp(&b.at_most())) else { continue };
            // Chains with help for nothing but what they do not sample at all, or what is dark, are a single method.
            let helps = |&i: &usize| parts[i].chains > 0.0 && parts[i].chains.is_finite();
            let alone = decision.chain_work == 0.0 || !sampled.iter().any(helps);
            match &mut mixture {
                _ if alone => single = better(single, decision),
                Some(best) => *best = better(best.clone(), decision),
                None => mixture = Some(decision),
            }
        }
    }
    let gain = if parts.iter().any(|part| part.rare) { 1.0 } else { MIXTURE_GAIN };
    Choice { mixture: mixture.filter(|mixture| mixture.product() < gain * single.product()), single }
}

fn better(a: Decision, b: Decision) -> Decision {
    let order = |d: &Decision| (d.product(), d.sample_work);
    if order(&b) < order(&a) { b } else { a }
}

fn chains_alone(budget: f64, parts: &[Costs]) -> Decision {
    Decision {
        independent: None,
        in_chains: vec![true; parts.len()],
        sample_work: 0.0,
        sample_error: 0.0,
        chain_work: budget,
        chain_products: products(parts.iter()),
    }
}

/// (Σ √B_i)², as it is to be expected and at most.
fn products<'a>(parts: impl Iterator<Item = &'a Costs>) -> [f64; 2] {
    let (b, most) = parts.fold((0.0, 0.0), |(b, most), part| (b + part.chains.sqrt(), most + part.at_most.sqrt()));
    [b * b, most * most]
}

/// The parts that method m samples best compared with chains: one, two, and so on.
fn easiest(m: usize, parts: &[Costs]) -> Vec<Vec<usize>> {
    let ratio = |i: usize| parts[i].independent[m] / parts[i].chains.sqrt().max(f64::MIN_POSITIVE);
    let mut order: Vec<usize> = (0..parts.len()).filter(|&i| parts[i].independent[m].is_finite()).collect();
    order.sort_by(|&i, &j| ratio(i).total_cmp(&ratio(j)));
    (1..=order.len()).map(|count| order[..count].to_vec()).collect()
}

/// Method m with n samples of each pixel for some parts, and chains for the others; `None` if the budget has no room for that.
fn mixed(budget: f64, (m, n, work): (usize, f64, f64), sampled: &[usize], parts: &[Costs]) -> Option<Decision> {
    let sample_work = n * work;
    // A method alone takes the power of two that is nearest. Chains get what remains, or what they can do with beyond it.
    let (alone, nearest) = (sampled.len() == parts.len(), std::f64::consts::SQRT_2);
    let chain_work = if alone { 0.0 } else { (budget - sample_work).max(LEAST_CHAINS * budget) };
    let fits = match alone {
        true => (budget / nearest..=budget * nearest).contains(&sample_work),
        false => sample_work + chain_work <= MOST_WORK * budget,
    };
    let mut in_chains = vec![true; parts.len()];
    sampled.iter().for_each(|&i| in_chains[i] = false);
    let sample_error = sampled.iter().map(|&i| parts[i].independent[m]).sum::<f64>() / n;
    let chain_products = products(parts.iter().zip(&in_chains).filter(|(_, chained)| **chained).map(|(part, _)| part));
    let independent = Some((m, n));
    fits.then_some(Decision { independent, in_chains, sample_work, sample_error, chain_work, chain_products })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(first: f64, second: f64, chains: f64) -> Costs {
        Costs { independent: vec![first, second], chains, at_most: chains, rare: false }
    }

    /// The best choice with so large a budget that rounding does not matter much.
    fn best(work: &[f64], parts: &[Costs]) -> Decision {
        decide(1e4, work, parts).best().clone()
    }

    fn method(decision: &Decision) -> Option<usize> {
        decision.independent.map(|(m, _)| m)
    }

    #[test]
    fn a_single_method_that_is_best_everywhere_is_taken_alone() {
        let easy = best(&[2.0, 8.0], &[part(1.0, 0.5, 30.0), part(2.0, 1.0, 50.0)]);
        assert_eq!((method(&easy), &easy.in_chains[..], easy.chain_share()), (Some(0), &[false; 2][..], 0.0));
        assert!((easy.product() / 6.0 - 1.0).abs() < 1e-12);
        assert_eq!(easy.independent, Some((0, 4096.0)));
        let second = best(&[2.0, 8.0], &[part(100.0, 0.5, 30.0), part(2.0, 1.0, 50.0)]);
        assert_eq!((method(&second), second.chain_share()), (Some(1), 0.0));
        let hard = best(&[2.0, 8.0], &[part(1e3, 1e3, 3.0), part(1e4, 1e6, 5.0)]);
        assert_eq!((hard.independent, &hard.in_chains[..], hard.chain_share()), (None, &[true; 2][..], 1.0));
    }

    #[test]
    fn a_part_that_is_hard_to_sample_is_left_to_chains() {
        let mixed = best(&[1.0, 4.0], &[part(1.0, 1.0, 400.0), part(1e5, 1e4, 9.0), part(0.0, 0.0, 0.0)]);
        assert_eq!((method(&mixed), &mixed.in_chains[..]), (Some(0), &[false, true, false][..]));
        assert!((16.0..16.5).contains(&mixed.product()) && (mixed.chain_share() - 0.75).abs() < 0.1);
    }

    #[test]
    fn in_doubt_it_is_the_mixture() {
        let mut parts = [part(1.0, 1.0, 400.0), part(9.0, 99.0, 4.0)];
        assert_eq!(best(&[1.0, 4.0], &parts).chain_share(), 0.0);
        parts[1].rare = true;
        assert!((best(&[1.0, 4.0], &parts).chain_share() - 0.67).abs() < 0.1);
    }

    #[test]
    fn a_method_that_does_not_sample_a_part_is_taken_for_others() {
        let short = best(&[1.0, 4.0], &[part(1.0, 1.0, 400.0), part(f64::INFINITY, 9.0, 9.0)]);
        assert_eq!((method(&short), &short.in_chains[..]), (Some(0), &[false, true][..]));
    }

    /// Light that nobody has met is not left to chains with no work.
    #[test]
    fn alone_means_all_parts() {
        let dark = [part(1.0, 1.0, 400.0), part(f64::INFINITY, 0.0, 0.0)];
        let Choice { single, mixture } = decide(64.0, &[1.0, 4.0], &dark);
        assert_eq!((method(&single), &single.in_chains[..]), (Some(1), &[false; 2][..]));
        assert!(mixture.is_some_and(|mixture| mixture.in_chains[1] && mixture.chain_work >= LEAST_CHAINS * 64.0));
    }

    #[test]
    fn of_equals_the_cheapest_is_taken() {
        for work in [[1.0, 40.0], [40.0, 1.0]] {
            let found = decide(4.0, &work, &[part(0.0, 0.0, f64::INFINITY), part(9e3, 9e3, 9.0)]);
            let cheapest = usize::from(work[1] < work[0]);
            assert_eq!((found.best().independent, found.best().chain_work), (Some((cheapest, 1.0)), 3.0));
        }
    }

    /// Whatever is dear, chains get what they are promised, and the work is the budget's.
    #[test]
    fn numbers_keep_to_the_budget() {
        let numbers = |seed: u32| (0..4).map(move |i| f64::from((seed * 7919 + i * 104_729) % 1000 + 1));
        for seed in 1..200 {
            let parts: Vec<_> = (numbers(seed).zip(numbers(3 * seed)).zip(numbers(5 * seed)))
                .map(|((a, b), c)| part(a, b, c * 3.0))
                .collect();
            for budget in [1.0, 3.0, 40.0] {
                let Choice { single, mixture } = decide(budget, &[1.0, 7.0], &parts);
                let off = single.work() / budget;
                assert!((0.7..1.42).contains(&off), "{single:?}");
                if let Some(mixture) = mixture {
                    assert!(
                        mixture.work() <= MOST_WORK * budget
                            && mixture.chain_share() > 0.09
                            && mixture.product() < single.product()
                    );
                }
            }
        }
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
            let ideal = (0..64).flat_map(|set| [product(0, set), product(1, set)]).fold(f64::INFINITY, f64::min);
            let Choice { single, mixture } = decide(1e4, &work, &parts);
            // Numbers of samples are powers of two, at most a factor √2 from the best, and a mixture has to be much better.
            let most = if mixture.is_some() { 1.1 } else { 1.1 / MIXTURE_GAIN };
            let found = mixture.unwrap_or(single).product() / ideal;
            assert!((0.999..most).contains(&found), "{found}");
        }
    }
}
