/* Fragments as packed keys hold them (docs/deferred.md, "Keys"), for the probe. */
#include "plan/offer.h"

#include <math.h>

static double kernel(const struct stp_plan *plan, double rho2)
{
    return plan->params.kernel == STP_KERNEL_GAUSS ? exp(-2 * rho2) : fmax(0, 1 - rho2);
}

/* 14 + 14 bits on the octahedron, of the device's frame: y down, z forward. */
static struct vec3 octahedral(struct vec3 n)
{
    const double steps = 8191;
    double l = fabs(n.x) + fabs(n.y) + fabs(n.z), x = n.x / l, y = -n.y / l, z = -n.z / l;
    if (z < 0) {
        double kept = x;
        x = (1 - fabs(y)) * (x >= 0 ? 1 : -1);
        y = (1 - fabs(kept)) * (y >= 0 ? 1 : -1);
    }
    x = round(x * steps) / steps;
    y = round(y * steps) / steps;
    z = 1 - fabs(x) - fabs(y);
    double fold = fmax(-z, 0);
    x += x >= 0 ? -fold : fold;
    y += y >= 0 ? -fold : fold;
    return v3_unit(v3(x, -y, -z));
}

void plan_quantise_packed(const struct stp_plan *plan, struct probe_fragment *f)
{
    double low = plan->frame.depth_low, scale = plan->frame.depth_scale;
    double step = fmin(fmax(floor((f->depth - low) * scale), 0), (1u << STP_DEPTH_BITS) - 1);
    f->depth = low + (step + 0.5) / scale;
    f->rho2 = floor(f->rho2 * STP_RHO_MOST + 0.5) / STP_RHO_MOST;
    f->weight = kernel(plan, f->rho2);
    f->normal = octahedral(f->normal);
}
