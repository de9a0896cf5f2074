// SPDX-License-Identifier: Apache-2.0
// Checks resources against the schemas of Kubernetes, cert-manager and the Prometheus Operator, which the packages of npm
// hold as compiled validators: types, choices, required fields. As `kubectl apply` does, a field that the schema does not
// name is refused.

// A validator reads each property of its schema, and runs over all keys of a free map. What it has not read is unknown.
function watched(value, read) {
  if (value === null || typeof value !== "object") return value;
  const known = read.get(value);
  if (known) return known.proxy;
  const keys = new Set();
  const proxy = new Proxy(value, {
    get(target, key) {
      keys.add(key);
      return watched(target[key], read);
    },
  });
  read.set(value, { proxy, keys });
  return proxy;
}

function unreadIn(value, read, path) {
  if (value === null || typeof value !== "object") return [];
  const keys = read.get(value)?.keys ?? new Set();
  return Object.keys(value).flatMap((key) => {
    const place = `${path}/${key}`;
    return Array.isArray(value) || keys.has(key) ? unreadIn(value[key], read, place) : [place];
  });
}

const kValidators = {
  "v1 ConfigMap": "kubernetes-models/_schemas/IoK8sApiCoreV1ConfigMap",
  "v1 Namespace": "kubernetes-models/_schemas/IoK8sApiCoreV1Namespace",
  "v1 Service": "kubernetes-models/_schemas/IoK8sApiCoreV1Service",
  "apps/v1 StatefulSet": "kubernetes-models/_schemas/IoK8sApiAppsV1StatefulSet",
  "batch/v1 Job": "kubernetes-models/_schemas/IoK8sApiBatchV1Job",
  "networking.k8s.io/v1 NetworkPolicy": "kubernetes-models/_schemas/IoK8sApiNetworkingV1NetworkPolicy",
  "policy/v1 PodDisruptionBudget": "kubernetes-models/_schemas/IoK8sApiPolicyV1PodDisruptionBudget",
  "cert-manager.io/v1 Certificate":
    "@kubernetes-models/cert-manager/_schemas/ComGithubCertManagerCertManagerPkgApisCertmanagerV1Certificate",
  "monitoring.coreos.com/v1 PodMonitor":
    "@kubernetes-models/prometheus-operator/_schemas/" +
    "ComGithubPrometheusOperatorPrometheusOperatorPkgApisMonitoringV1PodMonitor",
};

const validators = new Map();
for (const [kind, file] of Object.entries(kValidators)) {
  // By its path, since the packages export their classes alone, which read all fields.
  const module = await import(new URL(`node_modules/${file}.js`, import.meta.url));
  validators.set(kind, module.validate);
}

/** What is wrong with a resource, a sentence each. */
export function schemaProblems(resource) {
  const kind = `${resource.apiVersion} ${resource.kind}`;
  const validate = validators.get(kind);
  if (!validate) return [`${kind}: no schema is known for it`];
  const read = new Map();
  validate(watched(resource, read));
  const wrong = (validate.errors ?? []).map(
    ({ instancePath, keyword, params }) => `${kind}${instancePath}: ${keyword} ${JSON.stringify(params)}`,
  );
  return [...wrong, ...unreadIn(resource, read, "").map((place) => `${kind}${place}: there is no such field`)];
}

/** Resources with one field that is unknown, or one value that is an object instead: each must be refused. */
export function* spoilt(resource) {
  function* places(value, path) {
    if (value === null || typeof value !== "object") return;
    if (!Array.isArray(value)) yield [...path, "misspelt"];
    for (const key of Object.keys(value)) {
      if (value[key] === null || typeof value[key] !== "object") yield [...path, key];
      else yield* places(value[key], [...path, key]);
    }
  }
  for (const path of places(resource, [])) {
    if (["apiVersion", "kind"].includes(path.join())) continue; // they choose the schema
    const copy = structuredClone(resource);
    const owner = path.slice(0, -1).reduce((value, key) => value[key], copy);
    owner[path.at(-1)] = { misspelt: { misspelt: 1 } };
    yield { place: path.join("."), resource: copy };
  }
}
