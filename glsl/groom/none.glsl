// Nothing is painted: the statements that read a groom are left out.
// Source: ours.
#define groomed(code)
