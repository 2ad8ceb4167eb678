// Warps and DMFs act in full everywhere: the statements for other strengths are left out.
// Source: ours.
#define amounted(code)
