#pragma once

#include "figure/page_assets.hpp"

namespace tendril::app {

extern const PageAsset live_script;

}  // namespace tendril::app
