// Classification in two phases: a ray finds where there is matter, and only there asks what it is.
// Source: ours: lavapipe runs both sides of every branch, so that what is seldom asked for must not stand beside what always is.
// find_density reads what decides whether there is matter, before any DMF; matter_at is asked for the place found last, and
// of what it asks again the compiler leaves out what is known or not read. classify is both at once.
// The classification says what to look at: look, whether hard matter that was found is met: begins, and what is there:
// matter, premultiplied linear RGBA of a sample whose density before any DMF is above 0; hard: at least 1.
#define TWO_PHASES

Sample look(vec3 x);
bool begins(vec3 x, float path);
vec4 matter(Sample s, float path, bool hard);

float distance_found = 0.0, density_found = 0.0;

float find_density(vec3 x) {
    Sample s = look(x);
    distance_found = s.distance;
    density_found = s.density;
    return s.density;
}

vec4 matter_at(vec3 x, float path, bool hard) {
    Sample s = sample_object(x);
    s.distance = distance_found;
    s.density = density_found;
    return matter(s, path, hard);
}

vec4 classify(vec3 x, float path) {
    float density = find_density(x);
    bool hard = density >= 1.0;
    return density > 0.0 && (!hard || begins(x, path)) ? matter_at(x, path, hard) : vec4(0.0);
}
