// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <optional>
#include <string_view>
#include <tuple>

#include "renderer/vulkan/gpu.hpp"
#include "renderer/vulkan/shader_interface.hpp"
#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool contains_any_case(std::string_view text, std::string_view part) {
  const auto equal = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), equal) != text.end();
}

VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT /*severity*/,
                                             VkDebugUtilsMessageTypeFlagsEXT /*types*/,
                                             const VkDebugUtilsMessengerCallbackDataEXT* message,
                                             void* counter) {
  static_cast<Counter*>(counter)->add();
  std::fprintf(stderr, "vulkan validation: %s\n", message->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(Counter& counter) {
  return {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
          .messageSeverity =
              VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
          .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
          .pfnUserCallback = count_message,
          .pUserData = &counter};
}

bool has_validation_layer() {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::ranges::any_of(layers, [](const VkLayerProperties& layer) {
    return std::string_view(layer.layerName) == kValidationLayer;
  });
}

bool has_extension(std::string_view name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data());
  return std::ranges::any_of(extensions, [&](const VkExtensionProperties& extension) {
    return std::string_view(extension.extensionName) == name;
  });
}

std::string_view kind_name(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return kProcessorKind;
    default:
      return "other device";
  }
}

/// Smaller is better.
int rank(std::string_view kind) {
  constexpr std::array<std::string_view, 5> kOrder = {"discrete GPU", "integrated GPU", "virtual GPU",
                                                      "other device", kProcessorKind};
  return static_cast<int>(std::ranges::find(kOrder, kind) - kOrder.begin());
}

/// The compute family to use. It has timestamps. A family without graphics is preferred, since its queues run
/// concurrently with the display's work.
std::optional<std::uint32_t> compute_family(const std::vector<VkQueueFamilyProperties>& families) {
  std::optional<std::uint32_t> chosen;
  for (std::uint32_t index = 0; index < families.size(); ++index) {
    const VkQueueFlags flags = families[index].queueFlags;
    if ((flags & VK_QUEUE_COMPUTE_BIT) == 0 || families[index].timestampValidBits == 0) continue;
    const bool compute_only = (flags & VK_QUEUE_GRAPHICS_BIT) == 0;
    if (!chosen || (compute_only && families[index].queueCount > 1)) chosen = index;
  }
  return chosen;
}

void refuse_for_features(GpuCandidate& candidate) {
  VkPhysicalDeviceVulkan13Features features13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features features12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                              .pNext = &features13};
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                     .pNext = &features12};
  vkGetPhysicalDeviceFeatures2(candidate.physical, &features);
  const std::pair<VkBool32, const char*> wanted[] = {{features12.timelineSemaphore, "timelineSemaphore"},
                                                     {features12.scalarBlockLayout, "scalarBlockLayout"},
                                                     {features12.hostQueryReset, "hostQueryReset"},
                                                     {features13.synchronization2, "synchronization2"},
                                                     {features13.maintenance4, "maintenance4"}};
  for (const auto& [present, name] : wanted) {
    if (present == VK_FALSE) candidate.refusals.push_back(fmt::format("it lacks the feature {}", name));
  }
}

void refuse_for_formats(GpuCandidate& candidate) {
  const std::pair<VkFormat, const char*> wanted[] = {{VK_FORMAT_R8_UNORM, "R8_UNORM"},
                                                     {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT"}};
  for (const auto& [format, name] : wanted) {
    VkFormatProperties properties{};
    vkGetPhysicalDeviceFormatProperties(candidate.physical, format, &properties);
    if ((properties.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT) == 0) {
      candidate.refusals.push_back(fmt::format("it cannot filter {} textures", name));
    }
  }
}

GpuCandidate examine(VkPhysicalDevice physical) {
  VkPhysicalDeviceDriverProperties driver{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &driver};
  vkGetPhysicalDeviceProperties2(physical, &properties);
  const VkPhysicalDeviceProperties& core = properties.properties;

  GpuCandidate candidate{.physical = physical,
                         .name = core.deviceName,
                         .kind = std::string(kind_name(core.deviceType)),
                         .driver = fmt::format("{} {}", driver.driverName, driver.driverInfo)};
  if (core.apiVersion < VK_API_VERSION_1_3) {
    candidate.refusals.push_back(fmt::format("it offers Vulkan {}.{}, expected 1.3",
                                             VK_API_VERSION_MAJOR(core.apiVersion),
                                             VK_API_VERSION_MINOR(core.apiVersion)));
    return candidate;  // such a driver does not fill in the newer features
  }

  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  if (const auto family = compute_family(families)) {
    candidate.queue_family = *family;
    candidate.queues = families[*family].queueCount;
  } else {
    candidate.refusals.push_back("it has no compute queue with timestamps");
  }
  const std::uint32_t needed =
      storage_buffers(has_useful_texels(core.limits) ? BufferAccess::kTexels : BufferAccess::kStorage);
  if (core.limits.maxPerStageDescriptorStorageBuffers < needed) {
    candidate.refusals.push_back(fmt::format("it takes {} storage buffers a shader, expected {}",
                                             core.limits.maxPerStageDescriptorStorageBuffers, needed));
  }
  refuse_for_features(candidate);
  refuse_for_formats(candidate);
  return candidate;
}

}  // namespace

Result<std::unique_ptr<GpuInstance>> GpuInstance::create(const Config& config) {
  std::unique_ptr<GpuInstance> made(new GpuInstance());
  if (config.validation && !has_validation_layer()) {
    return Error{ErrorCode::kNotFound,
                 "the Vulkan validation layer is not installed, expected the package "
                 "vulkan-validationlayers"};
  }
  if (auto created = made->create_instance(config); !created) return created.error();
  if (auto found = made->find_candidates(config); !found) return found.error();
  return made;
}

Result<void> GpuInstance::create_instance(const Config& config) {
  const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                      .pApplicationName = "fanlight",
                                      .apiVersion = VK_API_VERSION_1_3};
  const auto messenger = messenger_info(config.messages != nullptr ? *config.messages : validation_messages_);
  constexpr VkValidationFeatureEnableEXT kSynchronisation =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                         .pNext = &messenger,
                                         .enabledValidationFeatureCount = 1,
                                         .pEnabledValidationFeatures = &kSynchronisation};
  has_debug_utils_ = config.validation || has_extension(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  const std::array extensions = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                 VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                            .pApplicationInfo = &application,
                            .enabledExtensionCount = has_debug_utils_ ? 1U : 0U,
                            .ppEnabledExtensionNames = extensions.data()};
  if (config.validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = extensions.size();
  }
  const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {
    return Error{ErrorCode::kNotFound,
                 "no Vulkan driver was found, expected a GPU's driver or the package "
                 "mesa-vulkan-drivers"};
  }
  if (result != VK_SUCCESS) return vulkan_error("vkCreateInstance", result);
  if (!config.validation) return {};

  const auto create_messenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  const VkResult messaging = create_messenger(instance_, &messenger, nullptr, &messenger_);
  if (messaging != VK_SUCCESS) return vulkan_error("vkCreateDebugUtilsMessengerEXT", messaging);
  return {};
}

GpuInstance::~GpuInstance() {
  if (kept_) return;
  if (messenger_ != VK_NULL_HANDLE) {
    reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"))(instance_, messenger_, nullptr);
  }
  if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

Result<void> GpuInstance::find_candidates(const Config& config) {
  std::uint32_t count = 0;
  VkResult result = vkEnumeratePhysicalDevices(instance_, &count, nullptr);
  std::vector<VkPhysicalDevice> physicals(count);
  if (result == VK_SUCCESS) result = vkEnumeratePhysicalDevices(instance_, &count, physicals.data());
  // Loaders differ in whether an instance without any working driver fails here or is merely empty.
  if (result == VK_ERROR_INITIALIZATION_FAILED) return {};
  if (result != VK_SUCCESS) return vulkan_error("vkEnumeratePhysicalDevices", result);
  for (const VkPhysicalDevice physical : physicals) {
    GpuCandidate& candidate = candidates_.emplace_back(examine(physical));
    if (config.processor_as_gpu && candidate.kind == kProcessorKind) candidate.kind = kStandInKind;
  }
  std::ranges::stable_sort(candidates_, {}, [](const GpuCandidate& candidate) {
    return std::tuple(!candidate.refusals.empty(), rank(candidate.kind));
  });
  return {};
}

const GpuCandidate* GpuInstance::candidate(std::string_view name) const {
  const auto found = std::ranges::find_if(candidates_, [&](const GpuCandidate& candidate) {
    return candidate.refusals.empty() && contains_any_case(candidate.name, name);
  });
  return found == candidates_.end() ? nullptr : &*found;
}

}  // namespace fanlight
