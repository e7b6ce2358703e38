/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the steps k and the spacing s of an axis. lattice.h defines the symbols and the condition (F).
 *
 * Steps. The smallest gap between coordinates, g, is one step.
 *
 *   1. Exact case: all c_i - c_0 are multiples of g.  If g is at most the coarsest unit
 *      that occurs, this proves little: layers of 1.3 mm, written without decimals, look
 *      like layers of 1 mm of which some are absent.  Such a g is accepted only if all
 *      gaps are equal.
 *   2. Otherwise, coordinates are rounded: a gap of at most u may be one layer written in
 *      two ways, so let g now be the smallest gap above u; then s is in [g - u, g + u].  Because
 *      |c_i - c_0 - k_i s| <= |e_i| + |e_0| <= u, a step k_i restricts s to
 *      [(c_i - c_0 - u) / k_i, (c_i - c_0 + u) / k_i].  For each i in ascending order, if
 *      exactly one k_i is consistent with the interval of s found so far, this k_i narrows
 *      the interval.  If no k_i or several are consistent, this is an error.
 *
 * Unit. In a text without trailing zeros ("0", "0.47", "0.5"), the number of digits does not show the precision.
 * Therefore, the units that occur are tested from the finest to the coarsest, and the first unit for which a lattice is
 * found is used. The test of a finer unit is stricter, because it allows only smaller rounding errors.
 *
 * Spacing. The result is the feasible decimal with the fewest digits after the point. Of several such decimals, it is
 * the one nearest to (c_(m-1) - c_0) / n, where n = k_(m-1); of two equally near decimals, the smaller one. The left
 * side of (F) is a maximum of linear functions of s, so it is convex, and the feasible s form an interval. At an
 * infeasible s, let i be the index of the maximum and j that of the minimum in (F). The slope of the left side is k_j -
 * k_i, which shows on which side the interval lies. `probe` determines this side, and a bisection with `probe` searches
 * the multiples of 10^-d.
 *
 * If no decimal with nine digits is feasible (for example, for thirds of a millimetre), RHE((c_(m-1) - c_0) / n) is
 * tested with u + n pm in place of u in (F), because an error of half a picometre in the spacing becomes k / 2 pm after
 * k steps.
 *
 * If the spacings of several axes differ by at most 1 %, these axes share one spacing that is feasible for all of them.
 * The shared spacing is found in the same way. An isotropic grid thus remains isotropic.
 *
 * Ranges. |c_i - c_0| <= 1.6 * 10^13, u <= 10^12 and k <= 16383 < 2^14, so (c_i - c_0 + u) * k < 2.8 * 10^17. A
 * feasible s has s <= k_(m-1) s <= c_(m-1) - c_0 + u <= 1.7 * 10^13, so k s < 2.8 * 10^17. A spacing above 100 mm is
 * found like any other, and is later refused by the check of the grid (AR-GRID-3).
 */
#include "core/conditions.h"

#include "io/text/lattice.h"

#include <assert.h>
#include <stdlib.h>

#include "core/integer.h"

enum { STEPS_MAX = OST_DIM_MAX - 1 };
static const int64_t FEASIBLE_MAX = INT64_C(17000000000000); /* 1.7 * 10^13, see the ranges above */

/* An axis with its steps k and its unit u. */
typedef struct fit {
    const ost_lattice_axis *axis;
    int32_t *steps; /* axis->count elements */
    int64_t unit;   /* unit u in picometres */
} fit;

static int64_t unit_pm(int unit)
{
    int64_t pm = 1;
    for (int i = unit; i < OST_LATTICE_UNITS - 1; i++)
        pm *= 10;
    return pm;
}

static int64_t span(const fit *f, size_t i)
{
    return f->axis->value[i] - f->axis->value[0];
}

static int64_t extent(const fit *f)
{
    return span(f, f->axis->count - 1);
}

static int64_t last_step(const fit *f)
{
    return f->steps[f->axis->count - 1];
}

/* ------------------------------------------------------------------ errors */

static const char advice[] = "give the spacing (--spacing)";

/*
 * Reports that coordinate i does not fit the lattice. The error may also be in one of the two coordinates whose
 * distance was used as the step, so the message names all three.
 */
static ost_status no_lattice(const char *path, const ost_lattice_axis *axis, size_t i, int64_t gap, ost_error *err)
{
    char value[OST_PM_TEXT], step[OST_PM_TEXT], from[OST_PM_TEXT];
    size_t j = 1;
    while (j + 1 < axis->count && axis->value[j] - axis->value[j - 1] != gap)
        j++;
    return ost_fail(err, OST_ERR_INPUT,
                    "%s:%lld: %c = %s is not a whole number of steps from the lowest; the smallest step is %s mm, "
                    "from %s (lines %lld and %lld); %s", path, (long long)axis->line[i], axis->name,
                    ost_pm_format(axis->value[i], value), ost_pm_format(gap, step), ost_pm_format(axis->value[j - 1],
                    from), (long long)axis->line[j - 1], (long long)axis->line[j], advice);
}

static ost_status many_lattices(const char *path, const ost_lattice_axis *axis, size_t i, ost_error *err)
{
    char value[OST_PM_TEXT];
    return ost_fail(err, OST_ERR_INPUT,
                    "%s:%lld: %c = %s fits several lattices: its digits are too few to find the spacing; %s", path,
                    (long long)axis->line[i], axis->name, ost_pm_format(axis->value[i], value), advice);
}

static ost_status too_many_layers(const char *path, const ost_lattice_axis *axis, size_t i, int64_t gap, ost_error *err)
{
    char value[OST_PM_TEXT], step[OST_PM_TEXT];
    return ost_fail(err, OST_ERR_RANGE, "%s:%lld: %c = %s is more than %d steps of %s mm from the lowest; expected "
                    "at most %d voxels; %s", path, (long long)axis->line[i], axis->name, ost_pm_format(axis->value[i],
                    value), STEPS_MAX, ost_pm_format(gap, step), OST_DIM_MAX, advice);
}

/* ------------------------------------------------------------------- steps */

/*
 * Returns the smallest of the gaps that are larger than the argument `floor`, or 0 if there is no such gap. If the
 * pointer `greatest` is not NULL, stores the largest gap in *greatest.
 */
static int64_t smallest_gap(const ost_lattice_axis *axis, int64_t floor, int64_t *greatest)
{
    int64_t least = 0, most = 0;
    for (size_t i = 1; i < axis->count; i++) {
        int64_t gap = axis->value[i] - axis->value[i - 1];
        if (gap > floor && (least == 0 || gap < least))
            least = gap;
        most = gap > most ? gap : most;
    }
    if (greatest)
        *greatest = most;
    return least;
}

static bool exact_steps(const fit *f, int64_t coarsest)
{
    int64_t greatest, gap = smallest_gap(f->axis, 0, &greatest);
    if (gap <= coarsest && gap != greatest)
        return false;
    for (size_t i = 0; i < f->axis->count; i++) {
        if (span(f, i) % gap != 0 || span(f, i) / gap > STEPS_MAX)
            return false;
        f->steps[i] = (int32_t)(span(f, i) / gap);
    }
    return true;
}

/* A spacing num / den, with 1 <= den <= STEPS_MAX. */
typedef struct ratio {
    int64_t num, den;
} ratio;

static bool less(ratio a, ratio b)
{
    return a.num * b.den < b.num * a.den;
}

static ost_status rounded_steps(const char *path, const fit *f, ost_error *err)
{
    const ost_lattice_axis *axis = f->axis;
    int64_t u = f->unit, gap = smallest_gap(axis, u, NULL);
    if (gap == 0)
        return many_lattices(path, axis, axis->count - 1, err);
    ratio lo = {gap - u, 1}, hi = {gap + u, 1};
    f->steps[0] = 0;
    for (size_t i = 1; i < axis->count; i++) {
        int64_t d = span(f, i);
        int64_t k_lo = ost_ceil_div((d - u) * hi.den, hi.num), k_hi = ost_floor_div((d + u) * lo.den, lo.num);
        k_lo = k_lo < 0 ? 0 : k_lo;
        if (k_lo > k_hi)
            return no_lattice(path, axis, i, gap, err);
        if (k_lo < k_hi)
            return many_lattices(path, axis, i, err);
        if (k_lo > STEPS_MAX)
            return too_many_layers(path, axis, i, gap, err);
        f->steps[i] = (int32_t)k_lo;
        if (k_lo == 0)
            continue;
        ratio from = {d - u, k_lo}, to = {d + u, k_lo};
        lo = less(lo, from) ? from : lo;
        hi = less(to, hi) ? to : hi;
    }
    return OST_OK;
}

/* ----------------------------------------------------------------- spacing */

typedef enum side { HERE, ABOVE, BELOW, NOWHERE } side;

/*
 * Tests whether the spacing s is feasible for one axis, that is, whether (F) holds with u + slack in place of u.
 * Returns HERE if it is, otherwise the direction in which the feasible spacings lie, or NOWHERE if there are none.
 */
static side probe_axis(const fit *f, int64_t s, int64_t slack)
{
    int64_t most = INT64_MIN, least = INT64_MAX;
    int32_t k_most = 0, k_least = 0;
    for (size_t i = 0; i < f->axis->count; i++) {
        int64_t remainder = span(f, i) - f->steps[i] * s;
        if (remainder > most) {
            most = remainder;
            k_most = f->steps[i];
        }
        if (remainder < least) {
            least = remainder;
            k_least = f->steps[i];
        }
    }
    if (most - least <= f->unit + slack)
        return HERE;
    return k_most > k_least ? ABOVE : k_most < k_least ? BELOW : NOWHERE;
}

static side probe(const fit *const *fits, int count, int64_t s)
{
    side all = HERE;
    for (int i = 0; i < count; i++) {
        side one = probe_axis(fits[i], s, 0);
        if (one == NOWHERE || (one != HERE && all != HERE && one != all))
            return NOWHERE;
        all = one == HERE ? all : one;
    }
    return all;
}

/*
 * Returns the feasible multiple of q that is nearest to num / den. If two multiples are equally near, returns the
 * smaller one. Returns 0 if no multiple is feasible.
 *
 * Invariants of the bisection: the multiple near * q is infeasible, and its probe points towards far * q. The multiple
 * far * q is feasible, or its probe points towards near * q, or it is the end of the range.
 */
static int64_t nearest_multiple(const fit *const *fits, int count, int64_t q, int64_t num, int64_t den)
{
    int64_t m = num / (den * q);
    bool between = m * q * den != num;
    side below = m >= 1 ? probe(fits, count, m * q) : ABOVE;
    side above = between ? probe(fits, count, (m + 1) * q) : below;
    if (below == NOWHERE || above == NOWHERE)
        return 0;
    if (below == HERE && above == HERE)
        return num - m * q * den <= (m + 1) * q * den - num || !between ? m * q : (m + 1) * q;
    if (below == HERE)
        return m * q;
    if (above == HERE)
        return (m + 1) * q;
    if (below != above)
        return 0; /* one of m and m + 1 is too small and the other too large, so no multiple of q is feasible */
    int64_t step = above == ABOVE ? 1 : -1;
    int64_t near = step > 0 ? m + between : m, far = step > 0 ? FEASIBLE_MAX / q + 1 : 0;
    while ((far - near) * step > 1) {
        int64_t middle = near + (far - near) / 2;
        side at = probe(fits, count, middle * q);
        if (at == NOWHERE)
            return 0;
        if (at == above)
            near = middle;
        else
            far = middle;
    }
    return far > 0 && probe(fits, count, far * q) == HERE ? far * q : 0;
}

/*
 * Returns the spacing with the fewest digits that is feasible for all axes. Returns 0 if no decimal with up to nine
 * digits is feasible.
 */
static int64_t fewest_digits(const fit *const *fits, int count)
{
    const fit *longest = fits[0];
    for (int i = 1; i < count; i++)
        if (last_step(fits[i]) > last_step(longest))
            longest = fits[i];
    int64_t found = 0;
    for (int64_t q = OST_PM_PER_MM; q >= 1 && found == 0; q /= 10)
        found = nearest_multiple(fits, count, q, extent(longest), last_step(longest));
    return found;
}

static int64_t spacing_of(const fit *f)
{
    int64_t s = fewest_digits(&f, 1);
    if (s == 0) {
        s = ost_rhe_div(extent(f), last_step(f));
        s = probe_axis(f, s, last_step(f)) == HERE ? s : 0;
    }
    return s;
}

/* Finds the steps, the unit and the spacing of one axis. The steps and the unit are stored in *f. */
static ost_status find_axis(const char *path, fit *f, ost_pm *spacing, ost_error *err)
{
    const ost_lattice_axis *axis = f->axis;
    if (axis->count < 2)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: all samples lie in one layer, %c = %.9g, so the spacing along %c cannot be found; %s",
                        path, axis->name, ost_pm_to_mm(axis->value[0]), axis->name, advice);
    assert(axis->units != 0);
    int finest = OST_LATTICE_UNITS - 1, coarsest = 0;
    while (!(axis->units >> finest & 1))
        finest--;
    while (!(axis->units >> coarsest & 1))
        coarsest++;

    f->unit = unit_pm(finest) + axis->rounded;
    if (exact_steps(f, unit_pm(coarsest)) && (*spacing = spacing_of(f)) > 0)
        return OST_OK;
    ost_status first = OST_OK;
    for (int unit = finest; unit >= coarsest; unit--) {
        if (!(axis->units >> unit & 1))
            continue;
        f->unit = unit_pm(unit) + axis->rounded;
        /* Only the error for the finest unit is reported, because it is the most specific. */
        ost_error *to = first == OST_OK ? err : NULL;
        ost_status status = rounded_steps(path, f, to);
        if (status == OST_OK && (*spacing = spacing_of(f)) > 0)
            return OST_OK;
        if (status == OST_OK)
            status = no_lattice(path, axis, axis->count - 1, smallest_gap(axis, f->unit, NULL), to);
        first = first == OST_OK ? status : first;
    }
    return first;
}

static bool alike(int64_t a, int64_t b)
{
    int64_t difference = a < b ? b - a : a - b;
    return difference * 100 <= (a < b ? a : b);
}

/* Finds one common spacing for several axes. Returns false if the axes cannot share a spacing. */
static bool unify(const fit *fits, const int *which, int count, ost_pm spacing[3])
{
    const fit *group[3] = {NULL, NULL, NULL};
    for (int i = 0; i < count; i++) {
        group[i] = &fits[which[i]];
        if (!group[i]->axis || !alike(spacing[which[0]], spacing[which[i]]))
            return false;
    }
    int64_t shared = fewest_digits(group, count);
    for (int i = 0; i < count && shared > 0; i++)
        spacing[which[i]] = shared;
    return shared > 0;
}

ost_status ost_lattice_find(const char *path, const ost_lattice_axis axes[3], ost_pm spacing[3], ost_error *err)
{
    ost_status status = OST_OK;
    fit fits[3] = {{0}, {0}, {0}};
    for (int a = 0; a < 3 && status == OST_OK; a++) {
        if (spacing[a] != 0)
            continue;
        fits[a].axis = &axes[a];
        fits[a].steps = malloc(axes[a].count * sizeof *fits[a].steps);
        if (!fits[a].steps)
            status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu coordinates", path, axes[a].count);
        else
            status = find_axis(path, &fits[a], &spacing[a], err);
    }
    if (status == OST_OK) {
        static const int groups[4][3] = {{0, 1, 2}, {0, 1, 0}, {0, 2, 0}, {1, 2, 0}};
        bool unified = unify(fits, groups[0], 3, spacing);
        for (int g = 1; g < 4 && !unified; g++)
            unified = unify(fits, groups[g], 2, spacing);
    }
    for (int a = 0; a < 3; a++)
        free(fits[a].steps);
    return status;
}
