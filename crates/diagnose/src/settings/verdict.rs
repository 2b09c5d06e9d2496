//! Settings of search, selection, and verdict. Shares are of the excess unless they say otherwise; sizes are root mean squares in units
//! of the noise.

settings! {
    /// Search, selection, and verdict.
    VerdictSettings {
        /// What is noise, and what is motion.
        alarm: AlarmSettings = AlarmSettings::default(),
        /// Inputs between samples, and delays.
        signals: SignalSettings = SignalSettings::default(),
        /// Periods of disturbances.
        periods: PeriodSettings = PeriodSettings::default(),
        /// Changes during a run.
        jumps: JumpSettings = JumpSettings::default(),
        /// Exact fits of sets of candidates.
        search: SearchSettings = SearchSettings::default(),
        /// Which candidates are fitted and selected.
        selection: SelectionSettings = SelectionSettings::default(),
        /// Comparison with rivals.
        rivals: RivalSettings = RivalSettings::default(),
        /// What is named and reported.
        naming: NamingSettings = NamingSettings::default(),
        /// Columns that are not what the model takes them for.
        columns: ColumnSettings = ColumnSettings::default(),
        /// Where the model is wrong.
        places: PlaceSettings = PlaceSettings::default(),
    }

    /// What is noise, and what is motion.
    AlarmSettings {
        /// Fewest samples of a column in a window for which low and high frequencies can be told apart.
        fewest_samples: usize = 12,
        /// Least standard deviation of the noise, relative to the estimate from the column itself. Smaller residuals, of data
        /// without noise, may be the error of the simulation.
        least_noise: f64 = 0.2,
        /// A column holds motion if nine tenths of its values spread more than this many times as far as its noise would.
        motion_spread: f64 = 1.5,
        /// Standard deviations of the noise of two columns that differ by this factor more than their estimates weigh the columns
        /// wrongly; a column that differs from its estimate by this factor is reported.
        noise_off: f64 = 1.5,
    }

    /// Inputs between samples, and delays.
    SignalSettings {
        /// Curves replace straight lines between samples if at most this share of the excess remains with them.
        curves_worth: f64 = 0.5,
        /// Relative difference of two steps in time that are equal.
        even_steps: f64 = 0.01,
        /// The other hold is reported if at most this share of the excess remains with it, without any cause.
        other_hold_worth: f64 = 0.5,
        /// A delay is half a sampling time if it differs by at most this share of one, or by two standard deviations.
        near_half_sample: f64 = 0.05,
    }

    /// Periods of disturbances.
    PeriodSettings {
        /// Frequencies per cycle over the range of the data: between two of them, half a cycle apart, a wave loses a quarter of
        /// a cycle toward the ends of the data.
        steps_per_cycle: usize = 2,
        /// Most cycles over the range of the data.
        most_cycles: usize = 200,
        /// Steps between two neighboring frequencies around a peak. Where a motion reverses, a wave pushes longest in one
        /// direction, so that reversals dominate: frequencies a whole cycle apart fit them nearly as well as the true one, and
        /// half a cycle is too coarse to tell which peak is the highest.
        finer_steps: usize = 16,
        /// Most peaks that are refined.
        most_refined_peaks: usize = 24,
        /// Most periods that are tried.
        most_periods: usize = 6,
    }

    /// Changes during a run.
    JumpSettings {
        /// Fewest windows among whose starts an instant is looked for.
        fewest_windows: usize = 4,
        /// A change is tried if it promises this share of the excess: smaller ones may be the image of something else.
        least_share: f64 = 0.3,
        /// Most changes that are tried.
        most: usize = 3,
        /// Instants that are tried in the window before the best one, and in that after it.
        trials_per_window: usize = 4,
        /// Duration, over that of a window, from which the fit of a slow change starts.
        spread: f64 = 0.5,
    }

    /// Exact fits of sets of candidates.
    SearchSettings {
        /// Most windows that a search or a comparison uses: more cost time and change no verdict.
        most_windows: usize = 330,
        /// Lengths of windows, as shares of the longest, with which parameters that are far off start.
        shorter: Vec<f64> = vec![0.25, 0.0625],
        /// Share of a time limit after which the search for causes ends; the rest is for intervals and the gain.
        share_of_time: f64 = 0.7,
        /// What stays unexplained is looked at in these windows, too, where they are shorter than this many of those before.
        shorter_than: f64 = 0.75,
        /// Changes during a run and hidden masses are looked for where no other candidate promises this share of the excess.
        told: f64 = 0.9,
        /// Long windows are worth a search if a pair of candidates promises a residual of at most this many times the noise.
        within_reach: f64 = 3.0,
        /// Delays, lags, and filters that are fitted exactly where no pair promises that …
        most_late: usize = 8,
        /// … and the share of the excess that each has to promise for it.
        least_late: f64 = 0.3,
        /// Largest factor by which an amplitude may differ from the secant that it starts from: beyond it the secant is not valid.
        farthest: f64 = 2.0,
        /// How often a fit that diverged starts anew, each time with smaller amplitudes.
        most_returns: usize = 2,
        /// The factor by which these amplitudes are smaller.
        nearer: f64 = 0.25,
        /// Share of the model's excess below which, near the noise, the residual of an explanation is the inaccuracy of its laws:
        /// three per cent in amplitude, as no real part follows its law more exactly.
        inexact: f64 = 1e-3,
        /// Size below which residuals are near the noise.
        near_noise: f64 = 1.5,
        /// A parameter below this share of its nominal value has removed its term.
        vanished: f64 = 0.05,
        /// An effect is uncertain if the squares of its amplitudes over their standard deviations add up to less than this: five
        /// standard deviations.
        uncertain: f64 = 25.0,
        /// Where removing an effect that is not uncertain costs this many times what its amplitudes imply, the fit without it has
        /// stopped at another minimum.
        stopped_short: f64 = 10.0,
        /// A parameter is far from its nominal value beyond this share of it.
        far_parameter: f64 = 0.5,
        /// A term of which less than this share remains hides its sign: little is left for friction to resist.
        little_left: f64 = 0.5,
    }

    /// Which candidates are fitted and selected.
    SelectionSettings {
        /// Single candidates are fitted if and only if they promise at least this share of what the best one promises.
        near_best: f64 = 0.5,
        /// Most exact fits of singles per round.
        most_single_fits: usize = 5,
        /// Most exact fits of pairs per round.
        most_pair_fits: usize = 3,
        /// A cause must remove this share of the excess that is there without it.
        least_share: f64 = 0.1,
        /// Number of terms without a name that are tried on all windows, after a test on some of them.
        shortlist: usize = 25,
        /// Share of the excess of the named causes that terms without a name must remove.
        substantial: f64 = 0.2,
        /// Beyond the first few, single terms are fitted if and only if they promise at least this share of what the best one promises.
        near_best_term: f64 = 0.8,
        /// Most exact fits of single terms.
        most_terms_alone: usize = 8,
        /// Most exact fits of terms beside named causes.
        most_terms_beside: usize = 3,
        /// Most exact fits of pairs of terms.
        most_term_pairs: usize = 2,
    }

    /// Comparison with rivals.
    RivalSettings {
        /// Two explanations differ on unseen windows if the mean difference is this many standard errors: one-sided 1 %.
        different: f64 = 2.33,
        /// A rival stays if its sum of squares exceeds that of the chosen one by less than this many units of scatter.
        ///
        /// If the rival is the truth, at distance d (in standard deviations) from the chosen explanation, the difference is
        /// normal with mean −d² and standard deviation 2d. It exceeds 9 with probability Φ(−(d² + 9)/(2d)), at most Φ(−3) = 0.13 %
        /// for all d: so seldom is the truth excluded.
        margin: f64 = 9.0,
        /// The linearized problem may underrate what an exact fit gains by this factor.
        underrated: f64 = 0.6,
        /// A candidate that gains beside a cause at least this share of what it gains in its place explains something else.
        beside: f64 = 0.5,
        /// Most times that a rival takes a cause's place.
        most_swaps: usize = 4,
        /// Most exact fits per cause.
        most_fits: usize = 8,
    }

    /// What is named and reported.
    NamingSettings {
        /// Share of the excess that named causes must explain if structure remains; with less, the data are unexplained.
        least_explained: f64 = 0.5,
        /// Standard deviations that some amplitude of a cause must exceed if structure remains, which covers the uncertainty of
        /// the cause's shape; if only noise remains, one is enough.
        sure: f64 = 2.0,
        /// One-sided level at which a parameter must have left its tolerance.
        outside_tolerance: f64 = 0.05,
        /// A saturation acts on at least this share of the samples of its input.
        least_beyond_limit: f64 = 0.01,
        /// Causes must take at least this share of the error away with which held-out data are predicted at the longest horizon.
        least_gain: f64 = 0.01,
        /// Where structure remains, causes have a name if they take at least this share of that error away.
        clear_gain: f64 = 0.3,
        /// Where structure remains, causes have a name if they explain at least this share of the excess: what explains less is as well the
        /// image of what the library lacks.
        clear_share: f64 = 0.85,
        /// The same if they make the force error at most this many times larger.
        most_force_error: f64 = 1.25,
        /// Most candidates in the report.
        listed_candidates: usize = 15,
        /// Most parameters of a combination that are fitted alone.
        most_alone: usize = 4,
        /// Fewest windows that are resampled.
        fewest_resampled: usize = 5,
        /// A named cause beside terms without a name keeps its name if it explains this share of what is there without it: else
        /// what the library lacks is larger, and the cause may be its image.
        uncertain_share: f64 = 0.5,
        /// One of several causes has no name if it removes less than this share of the model's excess, 7 % of it in
        /// amplitude, and a cause of another name explains the data as well: hardly any law is more exact, so that it may be the
        /// image of what another cause's law leaves, and a name would be a guess.
        least_of_several_kinds: f64 = 5e-3,
        /// Stribeck friction within this many standard deviations of none at rest is no dry friction: one-sided 1 %.
        near_no_friction: f64 = 2.33,
        /// A run for validation whose residual is this many times that of the fit is reported.
        much_more: f64 = 1.5,
    }

    /// Columns that are not what the model takes them for: sign, unit, order.
    ColumnSettings {
        /// Windows by which the model as it stands is judged; a reading of the columns is judged by the worst of them first.
        windows: usize = 8,
        /// There, the initial state is fitted until a step takes less than this share of the sum of squares away.
        roughly: f64 = 0.9,
        /// A reading is worth a fit if the model as it stands leaves at most this share of the squares that it leaves with the columns as
        /// they are.
        worth: f64 = 0.25,
        /// Most readings that are fitted.
        refitted: usize = 6,
        /// A residual of at most this many times the noise is noise.
        noise: f64 = 1.05,
        /// With the right columns, no parameter changes by more than this factor.
        far: f64 = 2.0,
        /// Where refitted parameters explain the data of the columns as they are, one of them has changed by more than this factor if a
        /// unit is wrong instead.
        change: f64 = 5.0,
        /// Or several have changed by more than this factor.
        together: f64 = 2.5,
        /// There, no parameter changes by more than this factor with the right unit.
        exact: f64 = 1.1,
    }

    /// Where the model is wrong.
    PlaceSettings {
        /// A velocity below this share of its root mean square counts as near rest.
        near_rest: f64 = 0.1,
        /// Near rest for this many times as long as a reversal at typical acceleration takes is rest.
        lingering: f64 = 4.0,
        /// Equations with a smaller share of the error are not divided by acceleration, position, and tilt.
        least_share: f64 = 0.01,
        /// Most angles per equation by whose sign the error is divided.
        most_angles: usize = 3,
        /// Most values over time in the report, per equation and stretch.
        most_values: usize = 500,
    }
}
