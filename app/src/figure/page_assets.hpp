#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "result/result_object.hpp"

namespace tendril::app {

/// A file of page/, and its SHA-256 in base64, by which a page allows it and nothing else.
struct PageAsset {
  std::string_view text, hash;
};
extern const PageAsset page_style, drawing_script;

/// What a page may run and show: `scripts`, its style, and nothing else. `connects`: it may ask the server that it came
/// from.
std::string page_policy(const std::vector<const PageAsset*>& scripts, bool connects);

/// What a page is made of.
struct PageParts {
  std::string title;
  std::string data_name;  ///< of the element that holds `data`
  const Json& data;
  std::vector<const PageAsset*> scripts;
  bool connects = false;
};
std::string page_of(const PageParts& parts);

}  // namespace tendril::app
