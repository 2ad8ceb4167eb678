// Where hard matter begins between the sample before, one step nearer to the eye, and this one. What is asked of the matter
// is its gap: a distance to the surface, object units, or anything with that sign; 0 or less inside.
// Source: ours. Where the signs of the ends differ, the crossing of a line through both gaps, again and again. Where a ray
// is outside at both ends it may cut off an edge between them: the gap is asked for where two lines meet that it lies above,
// if it is convex along the step and changes by no more than the way, as long as they meet below 0.
// Places along the step: 0 at the sample, 1 at the sample before.
struct StepBack {
    vec3 back;          // to the sample before, object space
    float size;         // its length
    float end;          // 1, or less where a plane cuts the step
    float at;           // the place that is asked for next
    vec2 far, near;     // the places around the surface that are known best, and their gaps
    vec2 between;       // the lowest known place between two that are outside
    vec2 rates;         // how fast, at most, the gap falls from both into what is between, per step
    int turn;
    bool met;           // it begins in this step
};
const int HERE = 0, BEFORE = 1, BETWEEN = 2, CLOSER = 10, HALVED = 14, LAST = 18;
const vec2 GRAZED = vec2(-1.0);
// How far, in steps, the gap may be from convex: trilinear distances bulge between voxels.
const float BULGE = 1.0 / 64.0;
// How near to the surface is near enough, in steps: one line more leads there.
const float CLOSE = 1.0 / 64.0;

// Number of turns after which a ray stops looking for edges: lavapipe counts those of all loops, and src/scene/rules/loops.rs counts on it.
const int MOST_TURNS = 32;
int turns = 0;

// The place where the lines from both ends meet, and how low.
vec2 meeting(vec2 far, vec2 near, vec2 rates) {
    float at = (far.y + rates.x * far.x - near.y + rates.y * near.x) / max(rates.x + rates.y, 1e-20);
    float shy = 0.125 * (near.x - far.x);           // the lines are steep where nothing better is known
    return vec2(clamp(at, far.x + shy, near.x - shy), near.y - rates.y * (near.x - at));
}

// How fast the gap falls from one place to another, per step.
float fall(vec2 from, vec2 to, float most) {
    return clamp((from.y - to.y) / max(abs(from.x - to.x), 1e-20), 0.0, most);
}

float gap_before = 0.0;     // of the sample taken last

// Whether the matter may begin between a sample and the one before, as far as the ray knows; gap: of the sample, size: no
// less than the step.
bool may_begin(float gap, float size) {
#ifdef ONE_SAMPLE
    return gap <= 0.0;
#else
    size *= steepness;
    bool apart = gap >= size || (follows && gap + gap_before >= (1.0 + 4.0 * BULGE) * size);
    gap_before = gap;
    return gap <= 0.0 || !apart;
#endif
}

StepBack step_back(vec3 x, float path) {
    vec3 back = mat3(texture_matrix) * (to_eye() * path);
    float size = length(back);
#ifdef ONE_SAMPLE
    vec2 part = vec2(0.0, 1.0);
#else
    vec2 part = kept(x, back);
#endif
    return StepBack(back, size, part.y, part.x, vec2(0.0), vec2(0.0), vec2(0.0), vec2(steepness * size), HERE, false);
}

// Ends with this answer: whether it begins in the step, and where.
bool last(inout StepBack s, bool met, float at) {
    s.met = met;
    s.at = at;
    s.turn = LAST;
    return false;
}

// Whether the matter is asked again, at another place; gap: what it is at this one. behind: what was asked last is to be
// behind the surface, however little; else the place is a better one, which was not asked for.
bool goes_on(inout StepBack s, float gap, bool behind) {
#ifdef ONE_SAMPLE
    return false;
#else
    if (s.turn >= LAST) return false;
    vec2 here = vec2(s.at, gap);
    float most = steepness * s.size;
    if (s.turn == HERE) {
        s.far = here;
        if (gap >= most || s.at > s.end || turns >= MOST_TURNS) return last(s, gap <= 0.0 && s.at <= s.end, s.at);
        if (gap + s.size + skip_slack < 0.0 && s.end >= 1.0) return last(s, true, s.at);    // no surface is within a step
        s.turn = BEFORE;
        s.at = s.end;
        return true;
    }
    turns += int(s.turn > BEFORE);
    if (s.far.y > 0.0) {                            // outside so far
        if (s.turn == BEFORE) {
            s.near = here;
            if (gap <= 0.0) return s.end < 1.0 ? last(s, true, s.end) : last(s, false, 0.0);
            s.turn = BETWEEN;
        } else if (gap <= 0.0) {
            s.far = here;
            s.turn = CLOSER;
            s.rates = GRAZED;
        } else {
            bool farther = here.x < s.between.x, lower = gap < s.between.y;
            if (s.turn > BETWEEN && farther == lower) {
                s.rates.y = fall(s.near, lower ? s.between : here, most);
                s.near = lower ? s.between : here;
            } else if (s.turn > BETWEEN) {
                s.rates.x = fall(s.far, lower ? s.between : here, most);
                s.far = lower ? s.between : here;
            }
            if (s.turn == BETWEEN || lower) s.between = here;
            ++s.turn;
        }
        if (s.turn < CLOSER) {
            vec2 low = meeting(s.far, s.near, s.rates);
            if (s.turn > BETWEEN) {
                // How the gap falls on one side bounds how fast it falls on the other.
                low = meeting(s.far, s.between, vec2(s.rates.x, fall(s.near, s.between, most)));
                vec2 other = meeting(s.between, s.near, vec2(fall(s.far, s.between, most), s.rates.y));
                if (other.y < low.y) low = other;
            }
            s.at = low.x;
            return low.y > BULGE * s.size || s.turn == CLOSER - 1 ? last(s, false, 0.0) : true;
        }
    } else {
        if (s.turn == BEFORE && gap <= 0.0) return last(s, true, s.end < 1.0 ? s.end : 0.0);    // cut open; inside before
        bool is_close = behind && gap <= 0.0 && gap >= -CLOSE * s.size && (s.rates != GRAZED || s.turn >= HALVED);
        if (s.turn > BEFORE && is_close) return last(s, true, s.at);
        if (gap <= 0.0) s.far = here;
        else s.near = here;
        s.turn = max(s.turn, CLOSER) + 1;
    }
    if (s.turn == LAST - 1) return last(s, true, s.far.x);
    float across = s.far.y / min(s.far.y - s.near.y, -1e-20);
    s.at = clamp(mix(s.far.x, s.near.x, across) - (behind ? 0.5 * CLOSE : 0.0), s.far.x, s.near.x);
    s.met = true;
    // Just behind the outline the gap is about 0 wherever the ray enters: the step is halved.
    if (s.rates == GRAZED && s.turn < HALVED) s.at = 0.5 * (s.far.x + s.near.x);
    else if (!behind && abs(s.at - here.x) <= 0.25 * CLOSE) s.turn = LAST;
    return s.turn < LAST;
#endif
}
