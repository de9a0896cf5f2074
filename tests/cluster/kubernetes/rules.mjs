// SPDX-License-Identifier: Apache-2.0
// What no schema says: names that resources refer to, the profile "restricted" of pod security, and our own decisions.

const kWorkloads = ["StatefulSet", "Job"];
// The kinds of volumes that the profile "restricted" allows.
const kHarmlessVolumes = [
  "configMap",
  "csi",
  "downwardAPI",
  "emptyDir",
  "ephemeral",
  "persistentVolumeClaim",
  "projected",
];
kHarmlessVolumes.push("secret");

export const podOf = (workload) => workload.spec.template.spec;
const containersOf = (pod) => [...(pod.initContainers ?? []), ...pod.containers];
export const workloadsOf = (resources) => resources.filter((each) => kWorkloads.includes(each.kind));
const named = (resources, kind, name) => resources.find((each) => each.kind === kind && each.metadata.name === name);
const selects = (selector, labels) => Object.entries(selector ?? {}).every(([key, value]) => labels?.[key] === value);

/** What the profile "restricted" of Kubernetes refuses in a pod. */
function restrictedProblems(pod) {
  const problems = [];
  for (const field of ["hostNetwork", "hostPID", "hostIPC"]) if (pod[field]) problems.push(field);
  for (const volume of pod.volumes ?? []) {
    const kind = Object.keys(volume).find((key) => key !== "name");
    if (!kHarmlessVolumes.includes(kind)) problems.push(`the volume ${volume.name} (${kind})`);
  }
  for (const container of containersOf(pod)) {
    const own = container.securityContext ?? {};
    const either = (field) => own[field] ?? pod.securityContext?.[field];
    if (own.privileged) problems.push("privileged");
    if (own.allowPrivilegeEscalation !== false) problems.push("allowPrivilegeEscalation");
    if (either("runAsNonRoot") !== true || either("runAsUser") === 0) problems.push("runAsNonRoot");
    if (!["RuntimeDefault", "Localhost"].includes(either("seccompProfile")?.type)) problems.push("seccompProfile");
    if (!own.capabilities?.drop?.includes("ALL")) problems.push("capabilities.drop");
    if (own.capabilities?.add?.some((name) => name !== "NET_BIND_SERVICE")) problems.push("capabilities.add");
    if (container.ports?.some((port) => port.hostPort)) problems.push("hostPort");
  }
  return problems;
}

function* selectorProblems(resources) {
  const templates = workloadsOf(resources).map((each) => each.spec.template);
  const selectors = {
    Service: (spec) => spec.selector,
    NetworkPolicy: (spec) => spec.podSelector.matchLabels,
    PodDisruptionBudget: (spec) => spec.selector.matchLabels,
    PodMonitor: (spec) => spec.selector.matchLabels,
  };
  for (const { kind, spec, metadata } of resources) {
    if (!selectors[kind]) continue;
    const selector = selectors[kind](spec);
    const matches = templates.some((template) => selects(selector, template.metadata.labels));
    if (!matches || Object.keys(selector ?? {}).length === 0) {
      yield `the selector of ${kind} ${metadata.name} matches no pod, or every pod`;
    }
  }
  for (const { kind, spec, metadata } of workloadsOf(resources)) {
    if (spec.selector && !selects(spec.selector.matchLabels, spec.template.metadata.labels)) {
      yield `the selector of ${kind} ${metadata.name} does not match its own pods`;
    }
  }
  const monitor = resources.find((each) => each.kind === "PodMonitor");
  if (monitor && !templates.some((template) => template.metadata.labels[monitor.spec.jobLabel] === "fanlight")) {
    yield `the jobLabel of the PodMonitor does not give the job name "fanlight"`;
  }
}

function* portProblems(resources) {
  const pods = workloadsOf(resources).map(podOf);
  const ports = pods.flatMap(containersOf).flatMap((container) => container.ports ?? []);
  const places = [];
  for (const { kind, spec, metadata } of resources) {
    const add = (what, port) => places.push([`${kind} ${metadata.name}, ${what}`, port]);
    if (kind === "Service") spec.ports.forEach((port) => add("targetPort", port.targetPort ?? port.port));
    if (kind === "NetworkPolicy") {
      spec.ingress?.forEach((rule) => rule.ports?.forEach((port) => add("ingress", port.port)));
    }
    if (kind === "PodMonitor") spec.podMetricsEndpoints.forEach((endpoint) => add("endpoint", endpoint.port));
    if (!kWorkloads.includes(kind)) continue;
    for (const container of containersOf(podOf({ spec }))) {
      for (const probe of ["startupProbe", "readinessProbe", "livenessProbe"]) {
        if (container[probe]?.httpGet) add(probe, container[probe].httpGet.port);
      }
    }
  }
  for (const [place, port] of places) {
    const exists = ports.some((each) => (typeof port === "string" ? each.name === port : each.containerPort === port));
    if (!exists) yield `${place}: no container has the port ${port}`;
  }
  for (const { kind, spec } of resources) {
    if (kind !== "StatefulSet") continue;
    const service = named(resources, "Service", spec.serviceName);
    if (service?.spec.clusterIP !== "None") yield `the StatefulSet's Service ${spec.serviceName} is no headless one`;
  }
}

function* volumeProblems(workload) {
  const pod = podOf(workload);
  const claims = (workload.spec.volumeClaimTemplates ?? []).map((claim) => claim.metadata.name);
  const volumes = new Set([...(pod.volumes ?? []).map((volume) => volume.name), ...claims]);
  const mounts = containersOf(pod).flatMap((container) => container.volumeMounts ?? []);
  for (const mount of mounts) {
    if (!volumes.has(mount.name)) yield `there is no volume ${mount.name} to mount at ${mount.mountPath}`;
    if (mount.subPath) yield `${mount.mountPath} is mounted by subPath and would never change`;
  }
  for (const name of volumes) {
    if (!mounts.some((mount) => mount.name === name)) yield `the volume ${name} is mounted nowhere`;
  }
}

/** `secrets`: those that the README tells to make. */
function* referenceProblems(resources, secrets) {
  const made = new Set(secrets);
  for (const { kind, spec } of resources) if (kind === "Certificate") made.add(spec.secretName);
  const needSecret = function* (name, place) {
    if (name !== undefined && !made.has(name)) yield `${place}: no one makes the Secret ${name}`;
  };
  for (const workload of workloadsOf(resources)) {
    const pod = podOf(workload);
    const maps = [
      ...(pod.volumes ?? []).map((volume) => volume.configMap?.name),
      ...containersOf(pod).flatMap((container) => (container.envFrom ?? []).map((each) => each.configMapRef?.name)),
    ].filter(Boolean);
    for (const name of maps) {
      if (!named(resources, "ConfigMap", name)) yield `there is no ConfigMap ${name}`;
    }
    for (const volume of pod.volumes ?? []) yield* needSecret(volume.secret?.secretName, `the volume ${volume.name}`);
  }
  for (const { kind, spec } of resources) {
    if (kind !== "PodMonitor") continue;
    for (const endpoint of spec.podMetricsEndpoints) {
      yield* needSecret(endpoint.authorization?.credentials?.name, "the PodMonitor");
      yield* needSecret(endpoint.tlsConfig?.ca?.secret?.name, "the PodMonitor");
    }
  }
}

function* securityProblems(resources) {
  const namespace = resources.find((each) => each.kind === "Namespace");
  const level = namespace?.metadata.labels?.["pod-security.kubernetes.io/enforce"] ?? "restricted";
  for (const workload of workloadsOf(resources)) {
    const pod = podOf(workload);
    const refused = restrictedProblems(pod);
    if (level === "restricted" && refused.length > 0) yield `pod security "restricted" refuses ${refused.join(", ")}`;
    if (level !== "restricted" && refused.length === 0) yield `the namespace may be "restricted", and is "${level}"`;
    if (pod.automountServiceAccountToken !== false) yield "the pod gets a token of the API, which it never needs";
    if (pod.enableServiceLinks !== false) yield "Kubernetes would set FANLIGHT_... variables (enableServiceLinks)";
    // Without a number a kubelet refuses the image, whose user is a name.
    if (!Number.isInteger(pod.securityContext?.runAsUser)) yield "runAsUser is not a number";
    for (const container of containersOf(pod)) {
      if (!container.securityContext?.readOnlyRootFilesystem) yield `${container.name}: its root can be written`;
      const limits = container.resources?.limits ?? {};
      if (!limits.cpu || !limits.memory) yield `${container.name}: no limit of processor or memory`;
      const threads = container.env?.find((variable) => variable.name === "LP_NUM_THREADS")?.valueFrom
        ?.resourceFieldRef;
      if (threads?.resource !== "limits.cpu" || threads.containerName !== container.name) {
        yield `${container.name}: LP_NUM_THREADS is not its limit of processors`;
      }
    }
  }
}

const secondsOf = (probe) => (probe?.periodSeconds ?? 10) * (probe?.failureThreshold ?? 3);

function* serviceProblems(workload, environment) {
  const [container] = podOf(workload).containers;
  const { startupProbe, readinessProbe, livenessProbe } = container;
  // A lost probe makes the pod not ready, and must not restart it.
  if (livenessProbe?.httpGet?.path !== "/healthz") yield "the livenessProbe does not ask /healthz";
  if (readinessProbe?.httpGet?.path !== "/readyz") yield "the readinessProbe does not ask /readyz";
  if (startupProbe?.httpGet?.path !== "/healthz") yield "the startupProbe does not ask /healthz";
  for (const probe of [startupProbe, readinessProbe, livenessProbe]) {
    if (probe?.httpGet?.scheme !== "HTTPS") yield "a probe asks without TLS";
  }
  if (secondsOf(startupProbe) < 120) yield "the startupProbe waits less than 120 s";
  if (secondsOf(livenessProbe) < 60) yield "the livenessProbe waits less than 60 s";
  if (Number(environment.FANLIGHT_PROBE_WAIT_S ?? 0) >= secondsOf(startupProbe)) {
    yield "the server waits longer for its probe than the startupProbe for the server";
  }
  if (workload.spec.replicas !== 1) yield "there is not exactly one replica";
  if (workload.spec.podManagementPolicy !== "Parallel") yield "an update would wait for a pod that is not ready";
}

function* sourceProblems(resources, workload, environment) {
  const source = environment.FANLIGHT_SOURCE ?? "";
  const pod = podOf(workload);
  const policy = resources.find((each) => each.kind === "NetworkPolicy");
  if (!policy) yield "there is no NetworkPolicy";
  const out = policy?.spec.egress;
  const scanner = /^igtl:([^,:]+)(?::(\d+))?/.exec(source);
  if (scanner) {
    const permits = (rule) =>
      rule.to?.some((peer) => peer.ipBlock?.cidr === `${scanner[1]}/32`) &&
      rule.ports?.some((port) => port.port === Number(scanner[2] ?? 18944));
    if (!out?.some(permits)) yield `the NetworkPolicy does not let the pod out to ${source}`;
  } else if (!policy?.spec.policyTypes?.includes("Egress") || !Array.isArray(out) || out.length > 0) {
    yield "the NetworkPolicy lets the pod out, and it needs nothing there";
  }
  const limits = Object.keys(pod.containers[0].resources?.limits ?? {});
  const has_probe =
    limits.some((name) => name.endsWith("/fanlight-probe")) ||
    pod.volumes?.some((volume) => volume.hostPath?.path === "/dev/bus/usb");
  if (source.startsWith("usb:") !== has_probe)
    yield `the source is ${source}, and the pod has ${has_probe ? "a" : "no"} probe`;
  const has_gpu = limits.includes("nvidia.com/gpu");
  if (has_gpu !== (environment.FANLIGHT_GPU !== undefined)) yield "a GPU and FANLIGHT_GPU do not come together";
}

/** The variables of a container but for those of the downward API. */
export function environmentOf(container, resources) {
  const environment = {};
  for (const each of container.envFrom ?? []) {
    Object.assign(environment, named(resources, "ConfigMap", each.configMapRef.name)?.data);
  }
  for (const { name, value } of container.env ?? []) if (value !== undefined) environment[name] = value;
  return environment;
}

function* jobProblems({ spec }) {
  const pod = podOf({ spec });
  const variable = (name) => pod.containers[0].env.find((each) => each.name === name)?.value;
  if (spec.completionMode !== "Indexed") yield "the Job is not Indexed";
  if (variable("SHARDS") !== String(spec.completions)) yield `SHARDS is not ${spec.completions}, the completions`;
  if (spec.parallelism > spec.completions) yield "more pods at once than completions";
  // What the API server demands beside these fields.
  if (pod.restartPolicy !== "Never") yield "backoffLimitPerIndex and podFailurePolicy need restartPolicy: Never";
  if (spec.podReplacementPolicy !== "Failed") yield "podFailurePolicy needs podReplacementPolicy: Failed";
  if (!(spec.backoffLimitPerIndex > 0)) yield "an index that fails is not tried again";
  const ignored = spec.podFailurePolicy.rules.find((rule) => rule.action === "Ignore");
  if (!ignored?.onPodConditions?.some((condition) => condition.type === "DisruptionTarget")) {
    yield "a drained node costs a try";
  }
}

/** What is wrong with the resources of an overlay, or of batch.yaml, a sentence each. */
export function ruleProblems(resources, secrets) {
  const problems = [
    ...selectorProblems(resources),
    ...portProblems(resources),
    ...referenceProblems(resources, secrets),
    ...securityProblems(resources),
  ];
  for (const workload of workloadsOf(resources)) {
    problems.push(...volumeProblems(workload));
    if (workload.kind === "Job") {
      problems.push(...jobProblems(workload));
    } else {
      const environment = environmentOf(podOf(workload).containers[0], resources);
      problems.push(...serviceProblems(workload, environment));
      problems.push(...sourceProblems(resources, workload, environment));
    }
  }
  return problems;
}
