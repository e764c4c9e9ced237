// How far the rim looks for discs.

// As far as pixels beside a point's own are looked at from the pixel: the centre of a disc that reaches
// a sample from so near is in one of the eight round it.
const float NEAR_REACH = 1.5;
// Pixels by which a disc is widened there, at most.
const float MOST_CROWD = 0.6;

// Some disc of the view reaches beyond those, as projecting the points has found: only then is anything
// left open.
bool discs_far()
{
    return RIM_FAR && frame.work.v[STP_WORK_FAR] != 0;
}
