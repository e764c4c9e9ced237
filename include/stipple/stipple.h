/* stipple: surfaces and media from points, range images and volumes, with Vulkan.
 *
 * The umbrella header. Only <stipple/vulkan.h> names Vulkan; include it yourself when you embed.
 *
 *   stp_scene_load -> stp_scene_prepare -> stp_plan_create -> stp_context_create
 *                  -> stp_render (own context)  or  stp_resident / stp_frame (vulkan.h)
 *
 * Every params struct may be zeroed: zero means the default that its comment states; and wherever a
 * function takes `params`, NULL means all defaults, but for stp_context_import, stp_frame_create
 * and stp_frame_scratch, which need to know what is the host's. env may be NULL as well. Every
 * function that can fail returns enum stp_result; on failure its outputs are untouched and one line
 * has gone to env->log. Destroy functions take the address, accept NULL and set it to NULL.
 *
 * Versions 0.x promise no stable binary interface: structs grow with every minor version, so
 * recompile what includes these headers with each. The numbers of enum stp_result stay. A library
 * of another version than it was compiled with shows when stp_version() is compared with
 * STP_VERSION.
 */
#ifndef STIPPLE_STIPPLE_H
#define STIPPLE_STIPPLE_H

#include <stipple/result.h>
#include <stipple/environment.h>
#include <stipple/scene.h>
#include <stipple/range.h>
#include <stipple/fit.h>
#include <stipple/volume.h>
#include <stipple/view.h>
#include <stipple/image.h>
#include <stipple/plan.h>
#include <stipple/render.h>
#include <stipple/compare.h>
#include <stipple/report.h>
#include <stipple/machines.h>

#endif
