// No wind: the statements that read it are left out.
// Source: ours.
#define windy(code)
