/* Every option of every command, once: parsing, --help and the man page come from this table. */
#include <float.h>
#include <string.h>

#include "cli.h"

#define INFO     COMMAND_INFO
#define RENDER   COMMAND_RENDER
#define PLAN     COMMAND_PLAN
#define PREPARE  COMMAND_PREPARE
#define COMPARE  COMMAND_COMPARE
#define DEVICES  COMMAND_DEVICES
#define REPORT   COMMAND_REPORT
#define PICTURE  (RENDER | PLAN)
#define VIEW     (RENDER | PLAN | REPORT)
#define VOLUMES  (INFO | RENDER | PLAN | REPORT)
#define POINTS   (RENDER | PLAN | PREPARE | REPORT)
#define ALL      (INFO | RENDER | PLAN | PREPARE | COMPARE | DEVICES | REPORT)
#define ABOVE_0  DBL_TRUE_MIN, DBL_MAX
#define AT(name) offsetof(struct settings, name)

/* clang-format off */
const struct option_spec option_table[] = {
    { "Output", RENDER, "output", 'o', "FILE.exr",
      "the picture: R G B A, Z and N.X N.Y N.Z as 32-bit floats, colour linear and premultiplied. "
      "With --frames the name holds %d or %04d. Required, unless only --stats is wanted; then "
      "nothing but the figures is written",
      value_path, AT(output), "a name that ends in .exr", 0, 0, NULL },
    { "Output", PREPARE, "output", 'o', "FILE.ply",
      "the prepared splats, as a binary PLY that reads back bit for bit. Required",
      value_path, AT(output), "a name that ends in .ply", 0, 0, NULL },
    { "Output", REPORT, "output", 'o', "DIR",
      "the folder that gets report.csv, report.svg, report.md and error_*.png; it is made when it "
      "is not there. Required",
      value_text, AT(output), "the name of a folder", 0, 0, NULL },
    { NULL, REPORT, "quick", 0, NULL,
      "fewer configurations and rounds (default: all)",
      value_flag, AT(quick), NULL, 0, 0, NULL },
    { NULL, REPORT, "rounds", 0, "N",
      "how often each configuration has its turn, for three timed frames each (default: 3, with "
      "--quick 2)",
      value_count, AT(rounds), "a whole number from 1 to 1000", 1, 1000, NULL },
    { NULL, RENDER, "deep", 0, "FILE.exr",
      "also write a deep EXR: a sample a layer (R G B A, Z, ZBack), front to back; of a transparent "
      "scene by --transparency exact or reference, with one sample a pixel. Without the background "
      "(default: none)",
      value_path, AT(deep), "a name that ends in .exr", 0, 0, NULL },
    { NULL, RENDER, "preview", 0, "FILE.png",
      "also write an 8-bit sRGB picture with straight alpha (default: none)",
      value_path, AT(preview), "a name that ends in .png", 0, 0, NULL },
    { NULL, RENDER, "exposure", 0, "STOPS",
      "brighten the preview by 2^STOPS; the EXR is not touched (default: 0)",
      value_real, AT(exposure), "a number from -64 to 64", -64, 64, NULL },
    { NULL, RENDER, "aov", 0, "LIST",
      "more channels, with commas between: albedo (before light), P (position), weight (sum of "
      "weights), fragments (how many were averaged), coverage (share of samples that hit), id "
      "(input index of the nearest splat, uint), layers (default: none)",
      value_names, AT(render.aovs),
      "names of albedo, P, weight, fragments, coverage, id, layers with commas between", 0, 0,
      aov_names },
    { NULL, RENDER, "half", 0, NULL,
      "write R G B A, N and albedo as 16-bit halves, clamped to +-65504 (default: 32-bit floats)",
      value_flag, AT(half), NULL, 0, 0, NULL },
    { NULL, RENDER, "compression", 0, "zip|none|zips|piz",
      "of the EXR; all are lossless, none is fastest (default: zip)",
      value_choice, AT(exr.compression), NULL, 0, 0, NULL },
    { NULL, RENDER, "stats", 0, "FILE.json",
      "write what was done, the times and the bytes (default: none)",
      value_text, AT(stats), "the name of a file", 0, 0, NULL },
    { NULL, PREPARE, "fit", 0, "TOL",
      "replace the points by few elliptical splats with linear normal fields: no point lies farther "
      "than TOL, in scene units, from the plane of a splat that holds it; 0: every point stays a "
      "splat (default: off)",
      value_real, AT(fit.tolerance), "a number from 0", 0, DBL_MAX, NULL },
    { NULL, PREPARE, "fit-count", 0, "N",
      "as --fit, with the tolerance that leaves at most N splats (default: off)",
      value_count, AT(fit_count), "a whole number from 1 to 4294967295", 1, UINT32_MAX, NULL },
    { NULL, PREPARE, "fit-color", 0, "TOL",
      "the colours of a splat's points differ by at most TOL, linear (default: 0.1)",
      value_real, AT(fit.color), "a number above 0", ABOVE_0, NULL },
    { NULL, PREPARE, "fit-flat", 0, NULL,
      "fit constant normals, not linear fields (default: off)",
      value_flag, AT(fit.flat), NULL, 0, 0, NULL },
    { NULL, PREPARE, "fit-alone", 0, NULL,
      "fit the field of each splat by itself, not all together for their mean where they overlap "
      "(default: off)",
      value_flag, AT(fit.alone), NULL, 0, 0, NULL },
    { NULL, PREPARE, "fit-smooth", 0, NULL,
      "do not look for sharp edges, at which splats are clipped (default: off)",
      value_flag, AT(fit.smooth), NULL, 0, 0, NULL },
    { NULL, PREPARE, "group", 0, NULL,
      "find the groups of the deferred method too, and store them (default: off)",
      value_flag, AT(with_groups), NULL, 0, 0, NULL },

    { "Camera", VIEW, "view", 0, "front|back|left|right|top|bottom|iso|AZ,EL",
      "the direction to look from; the scene is framed automatically. AZ and EL are degrees: 0,0 "
      "is front, 90,0 right, 0,90 top (default: iso, which is 35,25)",
      value_view, 0,
      "front, back, left, right, top, bottom, iso, or AZ,EL in degrees (AZ -360 to 360, EL -90 "
      "to 90)", 0, 0, NULL },
    { NULL, VIEW, "fov", 0, "DEG",
      "vertical field of view when framing (default: 30)",
      value_degrees, AT(frame.fov_y), "degrees above 0 and at most 175", DBL_TRUE_MIN, 175, NULL },
    { NULL, VIEW, "ortho", 0, NULL,
      "frame with an orthographic camera (default: perspective)",
      value_flag, AT(frame.orthographic), NULL, 0, 0, NULL },
    { NULL, VIEW, "camera", 0, "FILE.json",
      "a camera file, or a path of them (default: the camera of the scene .json; else --view)",
      value_text, AT(camera), "the name of a file", 0, 0, NULL },
    { NULL, RENDER, "frames", 0, "A:B",
      "render the cameras A to B, both included, of a camera path; the first is 0 (default: only "
      "the first)",
      value_frames, 0, "A:B, whole numbers with A <= B", 0, 999999, NULL },
    { NULL, RENDER, "split", 0, "points|frames",
      "started by mpirun or srun: all processes make each picture together, every one with its "
      "share of the points, by two-pass --path compute; or each makes frames of its own, by any "
      "method (default: points)",
      value_choice, AT(split), NULL, 0, 0, NULL },
    { NULL, RENDER, "write-camera", 0, "FILE.json",
      "write the camera that was used (default: none)",
      value_text, AT(write_camera), "the name of a file", 0, 0, NULL },
    { NULL, VIEW, "size", 0, "WxH",
      "pixels; wins over a camera file's size and scales its intrinsics (default: 1280x720, or "
      "the camera file's)",
      value_size, 0, "WIDTHxHEIGHT, each from 1 to 65536", 1, 65536, NULL },

    { "Scene", POINTS, "up", 0, "auto|x|y|z|-y",
      "the axis that points up (default: auto, what the file's format says, else y)",
      value_choice, AT(load.up), NULL, 0, 0, NULL },
    { NULL, POINTS, "clip-box", 0, "X0,Y0,Z0,X1,Y1,Z1",
      "leave out the points outside this box, in scene units (default: none)",
      value_clip_box, 0, "six numbers with commas between, the low corner first", 0, 0, NULL },
    { NULL, POINTS, "color-by", 0, "rgb|normal|height|intensity|class|views|FIELD",
      "what colours the points; FIELD is any scalar property of the file; views: range images, from "
      "all that see a point, by their angles (default: rgb where the file has colours, else the "
      "material's)",
      value_text, AT(load.color_by), "rgb, normal, height, intensity, class or a property's name",
      0, 0, NULL },
    { NULL, POINTS, "opacity", 0, "A",
      "of every object: multiplied with the points' and the materials' own, in the place of what a "
      "scene .json says of its objects; 0: nothing is seen (default: 1)",
      value_opacity, 0, "a number from 0 to 1", 0, 1, NULL },
    { NULL, POINTS, "transfer", 0, "auto|srgb|linear",
      "how colours are stored (default: auto, 8- and 16-bit sRGB, float linear)",
      value_choice, AT(load.transfer), NULL, 0, 0, NULL },
    { NULL, POINTS, "radius", 0, "R",
      "of points that bring none, in scene units (default: from the spacing of their neighbours)",
      value_intensity, AT(load.radius), "a number above 0", ABOVE_0, NULL },
    { NULL, PICTURE, "stream", 0, "auto|on|off",
      "leave the points of a binary PLY in the file and read them chunk by chunk; for method "
      "pyramid, where there are normals, and radii or --radius (default: auto, from 2^24 points "
      "on with --method pyramid)",
      value_choice, AT(stream), NULL, 0, 0, NULL },
    { NULL, POINTS, "two-sided", 0, "auto|on|off",
      "turn normals to the eye (default: auto, on where they were estimated or point inward, or "
      "the surface is open)",
      value_choice, AT(prepare.two_sided), NULL, 0, 0, NULL },

    { "Environment", POINTS, "environment", 0, "FILE",
      "what is around the scene, for its surfaces to mirror: a latitude-longitude map, OpenEXR or "
      "Radiance .hdr. Its top is up, its centre is ahead of --view front (default: that of the scene "
      ".json, else none)",
      value_text, AT(environment), "the name of a file", 0, 0, NULL },
    { NULL, POINTS, "environment-rotation", 0, "DEG",
      "turns it about up, counter-clockwise seen from above (default: 0)",
      value_degrees, AT(around.rotation), "degrees from -360 to 360", -360, 360, NULL },
    { NULL, POINTS, "environment-intensity", 0, "F",
      "multiplies its light (default: 1)",
      value_intensity, AT(around.intensity), "a number above 0 and at most 1e6", DBL_TRUE_MIN, 1e6,
      NULL },
    { NULL, POINTS, "ior", 0, "N|R,G,B",
      "of every surface: its index of refraction, or one a channel, from which follows what it "
      "mirrors; 1: nothing (default: that of the scene .json, else 1.5)",
      value_optics, AT(optics.ior), "a number from 0.05 to 20, or three with commas between", 0.05,
      20, NULL },
    { NULL, POINTS, "reflectance", 0, "F|R,G,B",
      "of every surface: what it mirrors face on, as metals do, in the place of what follows from "
      "--ior (default: that of the scene .json, else none)",
      value_optics, AT(optics.reflectance), "a number from 0 to 1, or three with commas between", 0,
      1, NULL },
    { NULL, POINTS, "roughness", 0, "F",
      "of every surface: 0 mirrors sharply, 1 nearly evenly (default: that of the scene .json, else "
      "0)",
      value_optics, AT(optics.roughness), "a number from 0 to 1", 0, 1, NULL },
    { NULL, POINTS, "absorption", 0, "A|R,G,B",
      "of every transparent surface: a layer of thickness T lets exp(-A T) pass, besides what its "
      "opacity stops (default: that of the scene .json, else 0)",
      value_optics, AT(optics.absorption), "a number from 0, or three with commas between", 0, 1e30,
      NULL },
    { NULL, POINTS, "thickness", 0, "T",
      "of a layer of every transparent surface (default: that of the scene .json, else 1)",
      value_optics, AT(optics.thickness), "a number from 0", 0, 1e30, NULL },
    { NULL, VIEW, "layers", 0, "multi|single",
      "an environment is seen through transparent surfaces bent and absorbed by all layers, or by "
      "the nearest alone (default: multi)",
      value_choice, AT(render.layers), NULL, 0, 0, NULL },

    { "Volume", VOLUMES, "volume-dims", 0, "X,Y,Z",
      "voxels along the axes of a raw file, x fastest (default: what the header, or a .json beside "
      "the file, says)",
      value_volume_dims, 0, "three whole numbers from 1 with commas between", 1, 4294967295.0,
      NULL },
    { NULL, VOLUMES, "volume-type", 0, "auto|u8|u16|i16|f32",
      "the voxels of a raw file, little-endian (default: auto, what the .json says, else u8)",
      value_choice, AT(load.volume.type), NULL, 0, 0, NULL },
    { NULL, VOLUMES, "volume-spacing", 0, "X,Y,Z",
      "distances of neighbouring voxels, in scene units (default: the file's, else 1,1,1)",
      value_volume_spacing, 0, "three numbers above 0 with commas between", 0, 0, NULL },
    { NULL, VOLUMES, "transfer-function", 0, "auto|grey|bone|flesh|hot|FILE.json",
      "colours and opacities of a volume's values: a preset, or a file (default: auto, from the "
      "histogram)",
      value_text, AT(load.volume.transfer_function), "a preset or the name of a file", 0, 0, NULL },
    { NULL, VOLUMES, "unshaded", 0, NULL,
      "show a volume's colours as they are (default: lit, by the gradients of its values)",
      value_flag, AT(load.volume.unshaded), NULL, 0, 0, NULL },

    { "Range images", VOLUMES, "range-splats", 0, "auto|ellipsoids|discs",
      "what a pixel becomes: an ellipsoid, stretched by the uncertainty of its depth, or a plain disc "
      "(default: auto, what the scene says, else ellipsoids)",
      value_choice, AT(load.range.splats), NULL, 0, 0, NULL },
    { NULL, VOLUMES, "uncertainty", 0, "X",
      "times the deviation of every depth; 0: depths are exact (default: what the scene says, else 1)",
      value_or_none, AT(load.range.uncertainty), "a number from 0", 0, 1e6, NULL },

    { "Picture", VIEW, "background", 0, "R,G,B[,A]|environment|none",
      "composited behind; linear light, alpha straight: it is multiplied in; or what --environment "
      "says (default: none, alpha 0 where nothing is)",
      value_background, 0, "none, environment, or R,G,B or R,G,B,A with A from 0 to 1", 0, 0, NULL },
    { NULL, PICTURE, "samples", 0, "N",
      "stratified samples a pixel, rounded up to a square number: smooth edges, and dense clouds "
      "that do not flicker, at N times the time; not with --path raster (default: 1)",
      value_count, AT(render.samples), "a whole number from 1 to 4096", 1, 4096, NULL },
    { NULL, VIEW, "kernel", 0, "parabola|gauss",
      "the weight of a splat at rho from its centre: 1 - rho^2, or exp(-2 rho^2), both within "
      "rho = 1 (default: parabola)",
      value_choice, AT(render.kernel), NULL, 0, 0, NULL },
    { NULL, VIEW, "epsilon", 0, "E",
      "how far behind the nearest splat others are still blended with it, in scene units "
      "(default: the median radius of each object)",
      value_real, AT(render.epsilon), "a number above 0", ABOVE_0, NULL },
    { NULL, VIEW, "min-splat", 0, "F",
      "the least diameter of a splat on the screen in pixels, so that small ones leave no holes; "
      "0 is off (default: 1.5)",
      value_min_splat, 0, "a number from 0 to 64", 0, 64, NULL },
    { NULL, VIEW, "cull", 0, "none|back",
      "leave out splats that face away from the eye (default: none)",
      value_choice, AT(render.cull), NULL, 0, 0, NULL },
    { NULL, PICTURE, "shade", 0, "pixel|splat|flat",
      "pixel: average normals, then shade once; splat: shade every splat, then average colours; "
      "flat: the nearest splat alone, by its one normal. The latter two by two-pass or reference "
      "(default: pixel)",
      value_choice, AT(render.shade), NULL, 0, 0, NULL },
    { NULL, PICTURE, "light-cube", 0, "auto|on|off",
      "look light up in a cube map over normals, made once a frame: for many directional lights "
      "(default: auto, which is off: it is nowhere measured faster)",
      value_choice, AT(render.light_cube), NULL, 0, 0, NULL },
    { NULL, VIEW, "local-viewer", 0, NULL,
      "highlights seen from the eye's place (default: from its direction, one for the picture)",
      value_flag, AT(render.local_viewer), NULL, 0, 0, NULL },

    { "Method", PICTURE, "method", 0, "auto|deferred|two-pass|exact|reference|pyramid|axis",
      "deferred: groups blended in one pass; two-pass: visibility, then blending; exact: every "
      "fragment kept and resolved; pyramid: one pixel a point, then pull and push, for clouds of "
      "many millions; reference: float64 on the CPU, slow, needs no Vulkan; axis: volumes, and "
      "points as Gaussians, by sorted axis lists (default: auto, of a volume axis, else the fastest within --max-error)",
      value_choice, AT(render.method), NULL, 0, 0, NULL },
    { NULL, PICTURE, "transparency", 0, "auto|fast|nearest|peel|exact|reference",
      "how layers behind each other are composited where something is transparent. exact: every "
      "fragment kept, cut into layers; reference: float64 on the CPU (default: auto, what --method "
      "says, else exact)",
      value_choice, AT(render.transparency), NULL, 0, 0, NULL },
    { NULL, PICTURE, "peel-layers", 0, "K",
      "peel: at most K layers, the nearest ones (default: 8)",
      value_count, AT(render.peel_layers), "a whole number from 1 to 1000", 1, 1000, NULL },
    { NULL, PICTURE, "max-error", 0, "E",
      "the most mean absolute error of linear RGB, over covered pixels and against the reference: "
      "auto takes the fastest way that keeps to it, from prices that were measured on the device, "
      "and may group the scene (default: 1e-4, without groups)",
      value_real, AT(render.max_error), "a number above 0", ABOVE_0, NULL },
    { NULL, PICTURE, "path", 0, "auto|raster|compute",
      "the device's rasteriser, or compute shaders (default: auto)",
      value_choice, AT(render.path), NULL, 0, 0, NULL },
    { NULL, PICTURE, "payload", 0, "auto|id|packed",
      "deferred by compute: a key carries the splat's number (exact) or packed attributes "
      "(default: auto)",
      value_choice, AT(render.payload), NULL, 0, 0, NULL },
    { NULL, PICTURE, "voronoi", 0, "auto|off|slab|exact",
      "deferred: who wins where splats of one group overlap (default: auto, slab where "
      "the overlap is below 1, else exact)",
      value_choice, AT(render.voronoi), NULL, 0, 0, NULL },
    { NULL, RENDER | PLAN | PREPARE, "overlap", 0, "C",
      "deferred: splats of one group may overlap as if shrunk by C; lower is faster and less "
      "exact (default: 0.85)",
      value_real, AT(group.overlap), "a number above 0 and at most 1", DBL_TRUE_MIN, 1, NULL },
    { NULL, POINTS, "groups", 0, "K",
      "deferred: at most K groups; where the colouring needs more, the overlap is lowered "
      "(default: 64). Transparencies fast and nearest: K groups that each cover the surface "
      "(default: 3)",
      value_count, AT(group.max_groups), "a whole number from 1 to 64", 1, STP_MAX_GROUPS, NULL },
    { NULL, POINTS, "relax", 0, "coplanar,opposed|none",
      "deferred: overlaps that need no separate groups: of flat neighbours of one colour, of "
      "splats that face opposite ways (default: opposed)",
      value_names, AT(group.relax), "coplanar, opposed, both with a comma between, or none", 0, 0,
      relax_names },
    { NULL, VIEW, "tile-memory", 0, "BYTES",
      "render in tiles when images and buffers would take more; K, M or G may follow (default: "
      "what the device has)",
      value_bytes, AT(render.memory_limit), "a whole number above 0, K, M or G may follow", 0, 0,
      NULL },

    { NULL, PICTURE, "axis-merge", 0, "auto|blend|clip|single|sort|reference",
      "axis: which list serves a pixel; blend: those whose axes are nearly dominant on its ray, "
      "clip: the dominant one's, single: one for the picture, sort: one by distance from the eye, "
      "reference: every ray's own order, in float64 on the CPU "
      "(default: auto, of --method axis blend, of --method auto sort)",
      value_choice, AT(render.axis_merge), NULL, 0, 0, NULL },
    { NULL, PICTURE, "axis-h", 0, "H",
      "axis, blend: the share of the dominant component of a ray above which another axis's list "
      "is blended in (default: 0.85)",
      value_axis_h, AT(render.axis_h), "a number from 0 and below 1", 0, 1, NULL },

    { "Device", RENDER | DEVICES | REPORT, "device", 0, "SUBSTRING",
      "the device whose name holds this (default: a GPU before a software device)",
      value_text, AT(context.device), "part of a device's name", 0, 0, NULL },
    { "Device", PLAN, "limits", 0, "FILE.json",
      "plan for this device, a profile that `stipple devices --json` printed (default: a "
      "built-in profile of Mesa's software device)",
      value_text, AT(limits), "the name of a file", 0, 0, NULL },
    { NULL, RENDER | DEVICES, "calibrate", 0, NULL,
      "measure the device's prices for auto again, and keep them (default: when --max-error is "
      "first used on the device)",
      value_flag, AT(calibrate), NULL, 0, 0, NULL },
    { NULL, VIEW, "mask-feature", 0, "NAME",
      "behave as if the device lacked it: int64-atomics, vertex-layer, float32-blend, int64, "
      "float64, storage-formats, independent-blend, texel-buffers, subgroup-shuffle; may be "
      "repeated (default: none)",
      value_features, AT(render.mask_features),
      "names of int64-atomics, vertex-layer, float32-blend, int64, float64, storage-formats, "
      "independent-blend, texel-buffers, subgroup-shuffle with commas between", 0, 0,
      NULL },
    { NULL, RENDER | REPORT, "validate", 0, NULL,
      "run under the Vulkan validation layers; any message is a failure (default: off)",
      value_flag, AT(context.validate), NULL, 0, 0, NULL },
    { NULL, RENDER, "repeat", 0, "N",
      "render N more frames and time them, for --stats (default: 0)",
      value_count, AT(repeat), "a whole number from 0 to 100000", 0, 100000, NULL },

    { "Comparison", COMPARE, "epsilon", 0, "E",
      "state depth errors as multiples of E, in scene units (default: none, absolute)",
      value_real, AT(compare.epsilon), "a number above 0", ABOVE_0, NULL },
    { NULL, COMPARE | REPORT, "exposure", 0, "STOPS",
      "brighten both pictures by 2^STOPS before FLIP (default: 0)",
      value_real, AT(compare.exposure), "a number from -64 to 64", -64, 64, NULL },
    { NULL, COMPARE, "fail-under-psnr", 0, "DB",
      "exit with status 1 when the PSNR over covered pixels is lower (default: never)",
      value_real, AT(least_psnr), "a number of decibels", -DBL_MAX, DBL_MAX, NULL },

    { "General", INFO | COMPARE | DEVICES, "json", 0, NULL,
      "print JSON (default: text)", value_flag, AT(json), NULL, 0, 0, NULL },
    { "General", ALL, "threads", 0, "N",
      "threads of the CPU half (default: one for each processor)",
      value_count, AT(threads), "a whole number from 1 to 256", 1, 256, NULL },
    { NULL, ALL, "quiet", 'q', NULL,
      "no progress bar and no warnings on stderr; errors only (default: off)",
      value_flag, AT(quiet), NULL, 0, 0, NULL },
    { NULL, ALL, "verbose", 0, NULL,
      "say what is being decided, on stderr (default: off)",
      value_flag, AT(verbose), NULL, 0, 0, NULL },
    { NULL, ALL, "help", 'h', NULL, "print this", NULL, 0, NULL, 0, 0, NULL },
    { NULL, ALL, "version", 'v', NULL, "print the version", NULL, 0, NULL, 0, 0, NULL },
};
/* clang-format on */

const unsigned option_count = sizeof option_table / sizeof *option_table;
_Static_assert(sizeof option_table / sizeof *option_table <= MOST_OPTIONS, "settings.given");
