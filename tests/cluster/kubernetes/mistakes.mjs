// SPDX-License-Identifier: Apache-2.0
// Mistakes that the check must find, each in a copy of deploy/kubernetes. `of`: the overlay that is checked then, or
// "files". `from` is replaced once by `to`; a problem must match `expect`.

const kSet = "base/statefulset.yaml";
const kToml = "base/fanlight.toml";
const kRoom = "overlays/room";
const kAny = "overlays/simulated";

const inSet = (name, from, to, expect) => ({ name, of: kAny, file: kSet, from, to, expect });
const inToml = (name, from, to, expect) => ({ name, of: kAny, file: kToml, from, to, expect });
const inRoom = (name, file, from, to, expect) => ({ name, of: kRoom, file, from, to, expect });
const inJob = (name, from, to, expect) => ({ name, of: "batch.yaml", file: "batch.yaml", from, to, expect });

const ofSchemas = [
  inSet(
    "a misspelt field",
    "terminationGracePeriodSeconds",
    "terminationGraceSeconds",
    /GraceSeconds: there is no such/,
  ),
  inSet("a misspelt field deep inside", "drop: [", "dropp: [", /capabilities\/dropp: there is no such field/),
  inSet("a number that is a word", "replicas: 1", "replicas: one", /replicas: type/),
  inSet("a word that is no choice", "scheme: HTTPS}", "scheme: https}", /scheme: enum/),
  inSet(
    "an unknown kind of restart",
    "podManagementPolicy: Parallel",
    "podManagementPolicy: Sidewards",
    /Policy: enum/,
  ),
  inSet("a field twice", "replicas: 1", "replicas: 1\n  replicas: 2", /unique/i),
  inSet("no selector", / +selector:\n +matchLabels:\n.*\n/, "", /required .*selector/),
  inRoom(
    "a misspelt field of cert-manager",
    "components/certificate/certificate.yaml",
    "renewBefore",
    "renewBevore",
    /no such/,
  ),
  inRoom(
    "a wrong type of cert-manager",
    "components/certificate/certificate.yaml",
    "size: 256",
    "size: large",
    /size: type/,
  ),
  inRoom(
    "a misspelt field of a PodMonitor",
    "components/monitoring/podmonitor.yaml",
    "tlsConfig",
    "tlsConfg",
    /no such field/,
  ),
  inRoom("a kind of Service", "overlays/room/service.yaml", "LoadBalancer", "LoadBalanser", /type: enum/),
  inJob("a misspelt field of the Job", "backoffLimitPerIndex: 4", "backoffLimitPerIndx: 4", /no such field/),
];

const ofFolders = [
  inSet("a file that is no YAML", "spec:\n  # A probe", "spec: [\n  # A probe", /statefulset.yaml: /),
  {
    name: "a resource that is not listed",
    ...{ of: kAny, file: "base/kustomization.yaml", from: "  - networkpolicy.yaml\n", to: "" },
    expect: /no NetworkPolicy/,
  },
  {
    name: "a resource that is not there",
    ...{ of: kAny, file: "base/kustomization.yaml", from: "services.yaml", to: "service.yaml" },
    expect: /service.yaml: there is no such file/,
  },
  {
    name: "a key that kustomize does not know",
    ...{ of: kAny, file: "base/kustomization.yaml", from: "resources:", to: "ressources:" },
    expect: /key ressources is not supported/,
  },
  inRoom(
    "a component that is not there",
    `${kRoom}/kustomization.yaml`,
    "components/gpu",
    "components/gpus",
    /no such file/,
  ),
  inRoom(
    "a patch for nothing",
    `${kRoom}/service.yaml`,
    "name: fanlight",
    "name: fanlite",
    /no resource Service fanlite/,
  ),
  inRoom(
    "a base as a component",
    `${kRoom}/kustomization.yaml`,
    "../../components/gpu",
    "../../base",
    /kind is Kustom/,
  ),
  {
    name: "a ConfigMap that is merged with none",
    ...{ of: "overlays/usb", file: "components/usb/kustomization.yaml", from: "fanlight-room", to: "fanlight-rooms" },
    expect: /no ConfigMap fanlight-rooms/,
  },
  {
    name: "a file that nothing uses",
    ...{ of: "files", file: `${kRoom}/kustomization.yaml`, from: "  - ../../components/state\n", to: "" },
    expect: /components\/state\/kustomization.yaml: no overlay uses it/,
  },
];

const inServices = (name, from, to, expect) => ({ name, of: kAny, file: "base/services.yaml", from, to, expect });
const inPolicy = (name, from, to, expect) => ({ name, of: kAny, file: "base/networkpolicy.yaml", from, to, expect });
const ofNames = [
  inServices(
    "a Service that selects nothing",
    "selector:\n    app.kubernetes.io/name: fanlight",
    "selector:\n    app: fanlight",
    /selector of Service fanlight matches/,
  ),
  inServices(
    "a Service with an unknown port",
    "targetPort: https",
    "targetPort: http",
    /Service fanlight, targetPort: no .* http$/,
  ),
  inServices("no headless Service", "clusterIP: None", "type: ClusterIP", /no headless one/),
  inPolicy(
    "a policy that selects nothing",
    "app.kubernetes.io/name: fanlight",
    "app.kubernetes.io/name: fan",
    /NetworkPolicy/,
  ),
  inPolicy(
    "a policy with an unknown port",
    "port: https",
    "port: http",
    /NetworkPolicy fanlight, ingress: no container/,
  ),
  inPolicy("a policy that lets out", "egress: []", "egress: [{}]", /lets the pod out/),
  inSet(
    "a probe of an unknown port",
    "path: /readyz, port: https",
    "path: /readyz, port: web",
    /readinessProbe: no container has/,
  ),
  inSet(
    "an unknown headless Service",
    "serviceName: fanlight-pods",
    "serviceName: pods",
    /Service pods is no headless/,
  ),
  inSet(
    "labels that the selector does not match",
    /template:\n +metadata:\n +labels:\n +app.kubernetes.io.name: fanlight/,
    "template:\n    metadata:\n      labels: {a: b}",
    /does not match its own pods/,
  ),
  inSet(
    "an unknown ConfigMap",
    "configMapRef:\n                name: fanlight-room",
    "configMapRef:\n                name: room",
    /no ConfigMap room/,
  ),
  inSet(
    "a Secret that no one makes",
    "secretName: fanlight-tls",
    "secretName: fanlight-cert",
    /no one makes the Secret fanlight-cert/,
  ),
  inSet("a mount without its volume", "- name: cache\n", "- name: caches\n", /no volume cache to mount/),
  inSet(
    "a file that would never change",
    "mountPath: /etc/fanlight-tls",
    "subPath: tls.crt, mountPath: /etc/fanlight-tls",
    /subPath/,
  ),
  inRoom(
    "a budget that selects nothing",
    "components/no-eviction/poddisruptionbudget.yaml",
    "io/name: fanlight",
    "io/name: fan",
    /Budget/,
  ),
  inRoom(
    "a PodMonitor that selects nothing",
    "components/monitoring/podmonitor.yaml",
    "matchLabels:\n      app.kubernetes.io/name: fanlight",
    "matchLabels:\n      app: x",
    /selector of PodMonitor/,
  ),
  inRoom(
    "a PodMonitor with an unknown port",
    "components/monitoring/podmonitor.yaml",
    "port: https",
    "port: metrics",
    /endpoint: no container/,
  ),
  inRoom(
    "a PodMonitor with another job",
    "components/monitoring/podmonitor.yaml",
    "jobLabel: app.kubernetes.io/name",
    "jobLabel: app",
    /jobLabel/,
  ),
];

const ofSecurity = [
  inSet("a pod that may be root", "runAsNonRoot: true", "runAsNonRoot: false", /refuses runAsNonRoot/),
  inSet(
    "a privileged container",
    "allowPrivilegeEscalation: false",
    "privileged: true",
    /refuses privileged, allowPriv/,
  ),
  inSet("all capabilities", 'drop: ["ALL"]', 'drop: ["KILL"]', /refuses capabilities.drop/),
  inSet("no seccomp", "type: RuntimeDefault", "type: Unconfined", /refuses seccompProfile/),
  inSet(
    "a root that can be written",
    "readOnlyRootFilesystem: true",
    "readOnlyRootFilesystem: false",
    /root can be written/,
  ),
  inSet("a folder of the node", "emptyDir: {}", "hostPath: {path: /var/lib/fanlight}", /refuses the volume state/),
  inSet(
    "a token of the API",
    "automountServiceAccountToken: false",
    "automountServiceAccountToken: true",
    /token of the API/,
  ),
  inSet("variables of Services", "enableServiceLinks: false", "enableServiceLinks: true", /enableServiceLinks/),
  inSet("the user of the image", "        runAsUser: 10001\n", "", /runAsUser is not a number/),
  inSet("no limit of memory", "              memory: 1536Mi\n", "", /no limit of processor or memory/),
  inSet("threads for each processor", "resource: limits.cpu", "resource: limits.memory", /LP_NUM_THREADS/),
  {
    name: "a privileged pod in a restricted namespace",
    ...{ of: "overlays/usb-host", file: "components/usb-host/kustomization.yaml", from: "  - path: namespace.yaml\n" },
    ...{ to: "", expect: /refuses the volume usb \(hostPath\), privileged/ },
  },
  {
    name: "a namespace that permits too much",
    ...{ of: kAny, file: "base/namespace.yaml", from: "enforce: restricted", to: "enforce: baseline" },
    expect: /may be "restricted"/,
  },
];

const ofDecisions = [
  inSet(
    "a restart for a lost probe",
    "livenessProbe:\n            httpGet: {path: /healthz",
    "livenessProbe:\n            httpGet: {path: /readyz",
    /livenessProbe does not ask/,
  ),
  inSet(
    "a probe without TLS",
    "path: /healthz, port: https, scheme: HTTPS",
    "path: /healthz, port: https",
    /without TLS/,
  ),
  inSet("a short first start", "failureThreshold: 60", "failureThreshold: 10", /waits less than 120 s/),
  inSet("two readers of a probe", "replicas: 1", "replicas: 2", /exactly one replica/),
  inSet(
    "an update that waits for the probe",
    "podManagementPolicy: Parallel\n",
    "podManagementPolicy: OrderedReady\n",
    /not ready/,
  ),
  {
    name: "a scanner that the policy keeps away",
    ...{ of: "overlays/igtl", file: "components/igtl/networkpolicy.yaml", from: "192.0.2.10", to: "192.0.2.11" },
    expect: /does not let the pod out to igtl:192.0.2.10/,
  },
  {
    name: "a wait for the probe that the kubelet ends",
    ...{ of: "overlays/igtl", file: "components/igtl/kustomization.yaml", from: "WAIT_S=100", to: "WAIT_S=200" },
    expect: /waits longer for its probe/,
  },
  {
    name: "a probe that the pod does not get",
    ...{
      of: "overlays/usb",
      file: "components/usb/statefulset.yaml",
      from: "squat.ai/fanlight-probe",
      to: "squat.ai/p",
    },
    expect: /the pod has no probe/,
  },
  {
    name: "a GPU that may stay unused",
    ...{
      of: "overlays/gpu",
      file: "components/gpu/statefulset.yaml",
      from: "nvidia.com/gpu: 1",
      to: "nvidia.com/mig: 1",
    },
    expect: /do not come together/,
  },
];

const inBase = (name, from, to, expect) => ({ name, of: kAny, file: "base/kustomization.yaml", from, to, expect });
const ofProgram = [
  inSet("an argument that is no option", '"--config"', '"--konfig"', /no option --konfig/),
  inSet("another command", 'args: ["serve"', 'args: ["server"', /expected serve/),
  inSet(
    "a shell that loses the arguments",
    'exec fanlight \\"$@\\"',
    "exec fanlight",
    /print-config: it printed no address/,
  ),
  inSet(
    "another port",
    "containerPort: 8443",
    "containerPort: 8444",
    /listens on the port 8443, and the port https is 8444/,
  ),
  inSet(
    "a cache that cannot be written",
    "value: /var/cache/fanlight",
    "value: /var/cache",
    /no volume that can be written/,
  ),
  inSet("a configuration in another place", "/etc/fanlight/fanlight.toml", "/etc/fanlight.toml", /print-config: /),
  inToml("an option that does not exist", "audit-log-mb", "audit-log-gb", /print-config: .*audit-log-gb/),
  inToml("a value that is refused", 'log-format = "json"', 'log-format = "xml"', /print-config: .*log-format/),
  inToml("a line that is no TOML", 'log-format = "json"', "log-format = json", /print-config: /),
  inToml("no tokens", /tokens = .*\n/, "", /would let everyone/),
  inToml("a key that is not mounted", "tls.key", "server.key", /print-config: .*server.key/),
  inToml(
    "an audit log outside",
    "/var/lib/fanlight/audit",
    "/var/log/fanlight/audit",
    /expected a folder for the audit log/,
  ),
  inToml(
    "an audit log among the secrets",
    "/var/lib/fanlight/audit",
    "/etc/fanlight-tls/audit",
    /no volume that can be written/,
  ),
  inBase("a variable that is no option", "FANLIGHT_TITLE=", "FANLIGHT_TITEL=", /reads no variable FANLIGHT_TITEL/),
  inBase("a source that is refused", 'phantom:"', 'phantom:scene=fase"', /print-config: .*fase/),
];

const ofJob = [
  inJob("shards that count from 0", "$((JOB_COMPLETION_INDEX + 1))", "$((JOB_COMPLETION_INDEX))", /expected sweep-2/),
  inJob("an option of batch that does not exist", "--shard", "--part", /expected sweep-2/),
  inJob("another number of shards", 'value: "16"', 'value: "8"', /SHARDS is not 16/),
  inJob("no end on a wrong manifest", "values: [2]", "values: [3]", /ends with 2, on which the Job does not fail/),
  inJob("an end on a full disk", "values: [2]", "values: [1, 2]", /on which the Job does not fail/),
  inJob(
    "a policy for another container",
    "containerName: batch\n          operator",
    "containerName: fanlight\n          operator",
    /does not fail at once/,
  ),
  inJob("a restart in place", "restartPolicy: Never", "restartPolicy: OnFailure", /need restartPolicy: Never/),
  inJob(
    "two pods of an index",
    "podReplacementPolicy: Failed",
    "podReplacementPolicy: TerminatingOrFailed",
    /needs podRepl/,
  ),
  inJob("a drain that costs a try", "type: DisruptionTarget", "type: Ready", /a drained node costs a try/),
  inJob("a Job without indices", "completionMode: Indexed", "completionMode: NonIndexed", /not Indexed/),
];

export const mistakes = [...ofSchemas, ...ofFolders, ...ofNames, ...ofSecurity, ...ofDecisions, ...ofProgram, ...ofJob];
